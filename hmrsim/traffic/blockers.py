"""Descriptions of the vehicles that block a waiting one: state, place, since when, and why they make no room."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final, NamedTuple

from hmrsim.geometry import PlaceNames
from hmrsim.world.derived import Derived

if TYPE_CHECKING:
    from hmrsim.world.model import World

_MOST_TOLD = 3
"""Blockers that are described; of more, the rest are counted."""


class Blocker(NamedTuple):
    """A vehicle for which another one waits.

    Attributes:
        robot: Its name.
        state: The state of the vehicle, such as ``idle`` or ``docked at 'charger_1'``.
        at: Where it is, by name if the place has one.
        since: When it last made progress, in simulated seconds; infinite while it does.
        why: Why it makes no room; empty where that is clear from its state.
    """

    robot: str
    state: str
    at: str
    since: float
    why: str

    def __str__(self) -> str:
        """Return all of it, as a part of a sentence."""
        since = f" since {self.since:g} s" if self.since < float("inf") else ""
        return f"{self.robot}, {self.state} at {self.at}{since}" + (f"; it {self.why}" if self.why else "")


def described(blockers: Sequence[Blocker]) -> str:
    """Return blockers as a part of a sentence."""
    more = len(blockers) - _MOST_TOLD
    rest = [f"{more} more"] if more > 0 else []
    return ", and by ".join([*map(str, blockers[:_MOST_TOLD]), *rest])


def _names_of(world: World) -> PlaceNames:
    places = {name: place.at for name, place in world.places.items()}
    docks = {name: dock.at for name, dock in world.docks.items() if not isinstance(dock.at, str)}
    return PlaceNames(world.points, places, docks)


place_names: Final = Derived(_names_of)
"""Returns the names of the waypoints, places and docks of a world."""
