"""The mappings of ROS names to Zenoh keys; a wire also defines whether messages have attachments."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Protocol

from hmrsim_zenoh.ros2 import keys
from hmrsim_zenoh.ros2.codec.distros import DISTROS
from hmrsim_zenoh.ros2.keys import Address


class Wire(Protocol):
    """A mapping of ROS names to Zenoh keys.

    Attributes:
        distros: The distributions whose types are served; only one where keys do not contain types.
        has_types: Whether keys have type and hash, messages an attachment, and endpoints liveliness tokens.
        request_keys: The key expressions on which requests arrive.
    """

    @property
    def distros(self) -> tuple[str, ...]: ...  # noqa: D102

    @property
    def has_types(self) -> bool: ...  # noqa: D102

    @property
    def request_keys(self) -> tuple[str, ...]: ...  # noqa: D102

    def read(self, key: str) -> Address | None:
        """Return a parsed key; None when it is not of this wire."""

    def key(self, name: str, type_: str = "*", hash_: str = "*") -> str:
        """Return the key of a topic or a service; by default with wildcards for type and hash.

        Args:
            name: Such as ``/wall_e/odom``; its chunks may be wildcards.
            type_: The type's name in keys.
            hash_: The type's hash.
        """


@dataclass(frozen=True)
class RmwZenoh:
    """The wire of ROS 2's own middleware for Zenoh, rmw_zenoh_cpp."""

    domain: int = 0
    distros: tuple[str, ...] = DISTROS
    has_types: Final = True

    @property
    def request_keys(self) -> tuple[str, ...]:
        """The key expressions on which requests come."""
        return (keys.everything(self.domain),)

    def read(self, key: str) -> Address | None:
        """Return what a key is about."""
        return keys.read_key(self.domain, key)

    def key(self, name: str, type_: str = "*", hash_: str = "*") -> str:
        """Return the key of a topic or a service."""
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
        """The key expressions on which requests come."""
        return ("*/*/_action/*", "*/*/get_state")

    def read(self, key: str) -> Address | None:
        """Return what a key is about."""
        return Address(f"/{key}")

    def key(self, name: str, type_: str = "*", hash_: str = "*") -> str:  # noqa: ARG002 - the other wire's
        """Return the key of a topic or a service."""
        return name.strip("/")
