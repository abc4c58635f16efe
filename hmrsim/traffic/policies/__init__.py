"""Traffic policies, which decide which vehicle may be where; one policy per file.

Waypoints and lanes are *slots*, numbered as in `hmrsim.navigation.lanes`: first the waypoints, then the lanes in either
direction.
A vehicle holds the slots of the leg that it drives, which are the lane and the waypoint at its end, or the slot that it
stands on. A policy decides when it may have them.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Annotated, Any, Final, Protocol

from pydantic import BaseModel, ConfigDict, Field

from hmrsim.plugins import discover
from hmrsim.traffic.policies._admission import AdmissionControl, Vehicle, Wait
from hmrsim.world.derived import Derived

__all__ = ["AdmissionControl", "Policy", "Rules", "Settings", "Vehicle", "Wait", "registry", "settings_of"]

if TYPE_CHECKING:
    from hmrsim.geometry import Point
    from hmrsim.navigation.route import Leg
    from hmrsim.world.model import World


class Settings(BaseModel):
    """The settings of traffic under every policy: unknown keys, NaN and infinity are errors.

    Attributes:
        policy: The policy's name; None where it is the default of the world.
        patience: Seconds that a robot waits before its goal is aborted; None for no limit.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True, allow_inf_nan=False)

    policy: str | None = None
    patience: Annotated[float, Field(strict=True, gt=0, le=1e9)] | None = 60.0


class Rules(Protocol):
    """A policy at work in one world."""

    def held(self, robot: Vehicle) -> tuple[int, ...]:
        """Return the slots that a vehicle holds, in the order in which it drives them."""

    def take(self, robot: Vehicle, leg: Leg) -> bool:
        """Give a vehicle the slots of a leg, and release all others that it holds; return whether it may have them."""

    def reset(self) -> None:
        """Forget the past; where vehicles stand stays as it is."""

    def stand(self, robot: Vehicle, slots: tuple[int, ...]) -> None:
        """Give a vehicle that stands these slots, also full ones, and release all others that it holds."""

    def leave(self, robot: Vehicle) -> None:
        """Release all slots of a vehicle."""

    def forget(self, robot: Vehicle, leg: Leg) -> None:
        """End the wait of a vehicle for a leg."""

    def spot(self, point: Point) -> int:
        """Return the slot of a point beside the lanes."""

    def full(self, slot: int) -> bool:
        """Return whether no other vehicle may come into a slot now."""

    def inside(self, slot: int) -> Sequence[Vehicle]:
        """Return the vehicles that hold a slot."""

    def near(self, slot: int, radius: float) -> Iterator[tuple[int, Vehicle]]:
        """Yield the slots so near to one, and who holds them, that a vehicle of this radius there would touch it."""

    def blockers(self, robot: Vehicle, leg: Leg) -> Sequence[Vehicle]:
        """Return the vehicles that hold what one would need for a leg."""

    def ahead_of(self, robot: Vehicle) -> Iterable[Vehicle]:
        """Return the vehicles whose turn is before that of one that waits, so that its patience does not count yet."""

    def why_stays(self, other: Vehicle, robot: Vehicle) -> str:
        """Return why a vehicle that is in another one's way makes no room, as the end of a sentence: "it …"."""

    def halted(self, robot: Vehicle) -> None:
        """Record that a vehicle was stopped on its leg, so that it will not arrive."""

    def stays_aside(self, robot: Vehicle) -> bool:
        """Return whether a vehicle that has yielded is to stay there; then the policy tells it to go on later."""

    def opened(self) -> None:
        """Record that a door opened, a cabin arrived, or a lane opened or closed."""

    def blocked(self, robot: Vehicle) -> None:
        """Resolve the wait of a vehicle that begins to wait, if that is possible."""


@dataclass(frozen=True)
class Policy:
    """One way to control traffic.

    Attributes:
        name: As in world files, and that of its module.
        settings: The model of its settings.
        rule: Makes the rules of one world; None where robots pass through each other.
    """

    name: str
    settings: type[Settings]
    rule: Callable[[AdmissionControl, Any], Rules] | None


@cache
def registry() -> dict[str, Policy]:
    """Return all policies by name."""
    return discover(sys.modules[__name__], "POLICY", Policy)


def _settings(world: World) -> Settings:
    return registry()[world.policy].settings.model_validate(world.traffic.model_dump())


settings_of: Final = Derived(_settings, "traffic", "robots", "robot_types")
"""Returns the settings of a world's policy, which must have been checked."""
