"""Doors that move."""

from __future__ import annotations

from typing import Annotated, Final

from pydantic import Field

from hmrsim.events._event import Event, EventGroup
from hmrsim.events._parts import Part

_By = Annotated[str, Field(description="The robot for which it opens; left out if a client opens it.")]


class DoorEvent(Event, subject=("door",), changes=Part.DOOR):
    """Something about a door."""

    door: Annotated[str, Field(description="The door's name.")]


class DoorOpening(DoorEvent, kind="door_opening", severity="debug", text="opens[ for {by}]", sets={"state": "opening"}):
    """A door begins to open."""

    by: _By = ""


class DoorOpened(
    DoorEvent, kind="door_opened", severity="debug", text="is open[ for {by}]", sets={"state": "open", "locked": False}
):
    """A door is open."""

    by: _By = ""


class DoorClosed(DoorEvent, kind="door_closed", severity="debug", text="is closed", sets={"state": "closed"}):
    """A door is closed."""


EVENTS: Final = EventGroup("doors", (DoorOpening, DoorOpened, DoorClosed))
