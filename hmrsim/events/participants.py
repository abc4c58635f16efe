"""Controllers that take part in lockstep."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Final

from pydantic import Field

from hmrsim.events._event import Event, EventGroup
from hmrsim.events._parts import Part

if TYPE_CHECKING:
    from collections.abc import Mapping

_Participant = Annotated[str, Field(description="The participant's name.")]
_Why = Annotated[str, Field(description="Why, unless it left by itself.")]


class ParticipantJoined(
    Event,
    kind="participant_joined",
    subject=("participant",),
    text="joins lockstep",
    changes=Part.PARTICIPANTS,
    sets={"present": True},
):
    """A controller takes part from now on."""

    participant: _Participant
    why: _Why = ""


class ParticipantLeft(
    Event,
    kind="participant_left",
    subject=("participant",),
    text="leaves lockstep[: {why}]",
    changes=Part.PARTICIPANTS,
    sets={"present": False},
):
    """A controller takes part no longer."""

    participant: _Participant
    why: _Why = ""


class ParticipantDropped(
    Event,
    kind="participant_dropped",
    severity="warning",
    subject=("participant",),
    text="is dropped from lockstep[: {why}]",
    changes=Part.PARTICIPANTS,
    sets={"present": False},
):
    """A controller was dropped, as it did not answer in time."""

    participant: _Participant
    why: _Why = ""


PARTICIPATION: Final[Mapping[str, type[ParticipantJoined | ParticipantLeft | ParticipantDropped]]] = {
    "joined": ParticipantJoined,
    "left": ParticipantLeft,
    "dropped": ParticipantDropped,
}
"""By how a controller's part in time changes."""

EVENTS: Final = EventGroup("participants", (ParticipantJoined, ParticipantLeft, ParticipantDropped))
