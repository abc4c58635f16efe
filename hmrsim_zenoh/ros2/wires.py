"""The ways in which ROS's names are spelled as Zenoh's keys: a wire says how, and what goes with a message."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Protocol

from hmrsim_zenoh.ros2 import keys
from hmrsim_zenoh.ros2.codec.distros import DISTROS
from hmrsim_zenoh.ros2.keys import Address


class Wire(Protocol):
    """One way.

    Attributes:
        distros: The distributions whose types are spoken; one where keys don't tell types.
        tells_types: Whether keys have type and hash, messages an attachment, and endpoints liveliness tokens.
        asked: The key expressions on which requests come.
    """

    @property
    def distros(self) -> tuple[str, ...]: ...  # noqa: D102

    @property
    def tells_types(self) -> bool: ...  # noqa: D102

    @property
    def asked(self) -> tuple[str, ...]: ...  # noqa: D102

    def read(self, key: str) -> Address | None:
        """Return what a key is about; None when it is none of this wire's."""

    def key(self, name: str, type_: str = "*", hash_: str = "*") -> str:
        """Return the key of a topic or a service; the wildcard of all types if none is given.

        Args:
            name: Such as ``/wall_e/odom``; its chunks may be wildcards.
            type_: The type's name as keys have it.
            hash_: The type's hash.
        """


@dataclass(frozen=True)
class RmwZenoh:
    """The wire of ROS 2's own middleware for Zenoh, rmw_zenoh_cpp.

    Attributes:
        domain: ROS's domain id.
        distros: The distributions whose types are spoken.
    """

    domain: int = 0
    distros: tuple[str, ...] = DISTROS
    tells_types: Final = True

    @property
    def asked(self) -> tuple[str, ...]:
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
    """The wire of zenoh-bridge-ros2dds, as Open-RMF's free_fleet speaks it: a key is the name, and nothing else.

    Robots alone are asked there, and what is no name of theirs is none of ours: real robots behind bridges may be on
    the same network.

    Attributes:
        distro: The distribution whose types are spoken: keys don't say, so there can be one only.
    """

    distro: str = "jazzy"
    tells_types: Final = False

    @property
    def distros(self) -> tuple[str, ...]:
        """The same as a tuple."""
        return (self.distro,)

    @property
    def asked(self) -> tuple[str, ...]:
        """The key expressions on which requests come."""
        return ("*/*/_action/*", "*/*/get_state")

    def read(self, key: str) -> Address | None:
        """Return what a key is about."""
        return Address(f"/{key}")

    def key(self, name: str, type_: str = "*", hash_: str = "*") -> str:  # noqa: ARG002 - the other wire's
        """Return the key of a topic or a service."""
        return name.strip("/")
