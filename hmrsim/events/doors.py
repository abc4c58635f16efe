"""Doors that move."""

from __future__ import annotations

from typing import Annotated, Final

from pydantic import Field

from hmrsim.events._event import Event, EventGroup
from hmrsim.events._parts import Part

_DoorName = Annotated[str, Field(description="The door's name.")]
_By = Annotated[str, Field(description="The robot for which it opens; left out if a client opens it.")]


class DoorOpening(
    Event,
    kind="door_opening",
    severity="debug",
    subject=("door",),
    text="opens[ for {by}]",
    changes=Part.DOOR,
    sets={"state": "opening"},
):
    """A door begins to open."""

    door: _DoorName
    by: _By = ""


class DoorOpened(
    Event,
    kind="door_opened",
    severity="debug",
    subject=("door",),
    text="is open[ for {by}]",
    changes=Part.DOOR,
    sets={"state": "open", "locked": False},
):
    """A door is open."""

    door: _DoorName
    by: _By = ""


class DoorClosed(
    Event,
    kind="door_closed",
    severity="debug",
    subject=("door",),
    text="is closed",
    changes=Part.DOOR,
    sets={"state": "closed"},
):
    """A door is closed."""

    door: _DoorName


EVENTS: Final = EventGroup("doors", (DoorOpening, DoorOpened, DoorClosed))
