"""Who may be where: one policy of traffic a file.

Waypoints and lanes are *slots*, numbered as `hmrsim.navigation.lanes` does: first the waypoints, then the lanes
whatever their direction. A robot occupies the slots of the leg that it drives, which are the lane and the waypoint at
its end, and what it stands on where it stands. A policy says when it may have them.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Annotated, Any, Protocol

from pydantic import BaseModel, ConfigDict, Field

from hmrsim.plugins import discover

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from hmrsim.navigation.route import Leg
    from hmrsim.robots.vehicle import Mobile
    from hmrsim.traffic.admission import Passage


class Settings(BaseModel):
    """What a world file may set of traffic, whatever the policy: unknown keys, NaN and infinity are errors.

    Attributes:
        policy: Its name.
        patience: Seconds for which a robot waits before it gives its goal up; None for ever.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    policy: str = "free"
    patience: Annotated[float, Field(strict=True, gt=0, le=1e9)] | None = 60.0


class Rules(Protocol):
    """A policy at work in one world."""

    def take(self, robot: Mobile, leg: Leg) -> bool:
        """Have a robot occupy the slots of a leg, and nothing else any more; return whether it may."""

    def begin_anew(self) -> None:
        """Forget what has been; who stands where stays so."""

    def stand(self, robot: Mobile, slots: tuple[int, ...]) -> None:
        """Have a robot that stands occupy these slots, and nothing else any more, whoever else is there."""

    def leave(self, robot: Mobile) -> None:
        """Let go of all that a robot occupies."""

    def forget(self, robot: Mobile, leg: Leg) -> None:
        """Let a robot wait for a leg no longer."""

    def full(self, slot: int) -> bool:
        """Return whether nobody else may come into a slot now."""

    def inside(self, slot: int) -> Sequence[Mobile]:
        """Return who occupies a slot."""

    def blockers(self, robot: Mobile, leg: Leg) -> Sequence[Mobile]:
        """Return who occupies what a robot would need for a leg."""

    def halted(self, robot: Mobile) -> None:
        """Take note that a robot has been stopped on its way, so that it will not arrive."""

    def keeps_aside(self, robot: Mobile) -> bool:
        """Return whether a robot that has made room is to stay there; if so, it will be told to go on."""

    def blocked(self, robot: Mobile) -> None:
        """Do something about a robot that has begun to wait, if there is anything to be done."""


@dataclass(frozen=True)
class Policy:
    """One way to rule traffic.

    Attributes:
        name: As in world files, and that of its module.
        settings: The model of its settings.
        rule: Makes the rules of one world; None where robots pass through each other.
    """

    name: str
    settings: type[Settings]
    rule: Callable[[Passage, Any], Rules] | None


@cache
def registry() -> dict[str, Policy]:
    """Return all policies by name."""
    return discover(sys.modules[__name__], "POLICY", Policy)
