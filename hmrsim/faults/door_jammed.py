"""The door jams: it stays open or closed, and does not carry out commands."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, cast

from hmrsim.faults import Case, FaultType, Name, Spell

if TYPE_CHECKING:
    from hmrsim.facilities.doors import Door


class DoorJammed(Spell):
    """The jam of a door.

    Attributes:
        door: The door's name.
    """

    door: Name


def _begin(case: Case[DoorJammed]) -> Callable[[], None]:
    door = cast("Door", case.roster.fixtures[case.settings.door])
    door.jam()
    return door.free


FAULT = FaultType(
    name="door_jammed", settings=DoorJammed, begin=_begin, example={"door": "gate"}, title="Jammed", changes="jammed"
)
