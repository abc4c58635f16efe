"""The mappings of ROS names to Zenoh keys, and the attachment of each message on rmw_zenoh's wire.

An attachment has 33 bytes: the sequence number and the time in nanoseconds as int64, the length of the id as one byte,
and the sender's id.
"""

from __future__ import annotations

from dataclasses import dataclass
from struct import Struct
from typing import Final, NamedTuple

from hmrsim_zenoh.ros2 import keys
from hmrsim_zenoh.ros2.codec.types import DISTROS
from hmrsim_zenoh.ros2.keys import Address

_LAYOUT: Final = Struct("<qqB16s")
_ID_BYTES: Final = 16


class Attachment(NamedTuple):
    """The sender of a message, request or reply, and the sequence number.

    Attributes:
        sequence: Counts from 1 for each sender. A reply has that of its request.
        stamp: Nanoseconds since 1970, of the wall clock.
        gid: 16 bytes. A reply has that of its request.
    """

    sequence: int
    stamp: int
    gid: bytes

    def to_bytes(self) -> bytes:
        """Return the attachment."""
        return _LAYOUT.pack(self.sequence, self.stamp, _ID_BYTES, self.gid)


def read_attachment(data: bytes) -> Attachment:
    """Return a parsed attachment.

    Raises:
        ValueError: It has not rmw_zenoh's layout.
    """
    if len(data) != _LAYOUT.size:
        raise ValueError(f"an attachment of {len(data)} bytes; rmw_zenoh's has {_LAYOUT.size}")
    sequence, stamp, length, gid = _LAYOUT.unpack(data)
    if length != _ID_BYTES:
        raise ValueError(f"an attachment with an id of {length} bytes; rmw_zenoh's has {_ID_BYTES}")
    return Attachment(sequence, stamp, gid)


@dataclass(frozen=True)
class RmwZenoh:
    """The wire of ROS 2's own middleware for Zenoh, rmw_zenoh_cpp.

    Attributes:
        domain: The domain id.
        distros: The distributions whose types are served.
        has_types: Whether keys have type and hash, messages an attachment, and endpoints liveliness tokens.
    """

    domain: int = 0
    distros: tuple[str, ...] = DISTROS
    has_types: Final = True

    @property
    def request_keys(self) -> tuple[str, ...]:
        """The key expressions on which requests arrive."""
        return (keys.everything(self.domain),)

    def read(self, key: str) -> Address | None:
        """Return a parsed key; None when it is not of this wire."""
        return keys.read_key(self.domain, key)

    def key(self, name: str, type_: str = "*", hash_: str = "*") -> str:
        """Return the key of a topic or a service; by default with wildcards for type and hash.

        Args:
            name: Such as ``/wall_e/odom``; its chunks may be wildcards.
            type_: The type's name in keys.
            hash_: The type's hash.
        """
        return keys.key(self.domain, name, type_, hash_)


@dataclass(frozen=True)
class Ros2Dds:
    """The wire of zenoh-bridge-ros2dds, which Open-RMF's free_fleet uses: a key is the name alone.

    Only robots are served there, and requests to other names are ignored: real robots behind bridges may be on the
    same network.

    Attributes:
        distro: The distribution whose types are served: only one, as keys do not contain types.
    """

    distro: str = "jazzy"
    has_types: Final = False

    @property
    def distros(self) -> tuple[str, ...]:
        """The distribution as a tuple."""
        return (self.distro,)

    @property
    def request_keys(self) -> tuple[str, ...]:
        """The key expressions on which requests arrive."""
        return ("*/*/_action/*", "*/*/get_state")

    def read(self, key: str) -> Address | None:
        """Return a parsed key; None when it is not of this wire."""
        return Address(f"/{key}")

    def key(self, name: str, type_: str = "*", hash_: str = "*") -> str:  # noqa: ARG002 - the other wire's
        """Return the key of a topic or a service."""
        return name.strip("/")


Wire = RmwZenoh | Ros2Dds
"""A mapping of ROS names to Zenoh keys."""
