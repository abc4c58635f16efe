"""Controllers that take part in lockstep."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Final

from pydantic import Field

from hmrsim.events._event import Event, EventGroup
from hmrsim.events._parts import Part


class ParticipantEvent(Event, subject=("participant",), changes=Part.PARTICIPANTS):
    """A change of who takes part."""

    participant: Annotated[str, Field(description="The participant's name.")]
    why: Annotated[str, Field(description="Why, unless it left by itself.")] = ""


class ParticipantJoined(ParticipantEvent, kind="participant_joined", text="joins lockstep", sets={"present": True}):
    """A controller takes part from now on."""


class ParticipantLeft(
    ParticipantEvent, kind="participant_left", text="leaves lockstep[: {why}]", sets={"present": False}
):
    """A controller takes part no longer."""


class ParticipantDropped(
    ParticipantEvent,
    kind="participant_dropped",
    severity="warning",
    text="is dropped from lockstep[: {why}]",
    sets={"present": False},
):
    """A controller was dropped, as it did not answer in time."""


PARTICIPATION: Final[Mapping[str, type[ParticipantEvent]]] = {
    "joined": ParticipantJoined,
    "left": ParticipantLeft,
    "dropped": ParticipantDropped,
}
"""By how a controller's part in time changes."""

EVENTS: Final = EventGroup("participants", (ParticipantJoined, ParticipantLeft, ParticipantDropped))
