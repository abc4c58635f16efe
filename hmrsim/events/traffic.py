"""Robots that block each other, and lanes that are closed."""

from __future__ import annotations

from typing import Annotated, Final

from pydantic import Field

from hmrsim.events._event import Event, EventGroup
from hmrsim.events._fields import LaneName, Number, Position, RobotName, RobotNames
from hmrsim.events._parts import Part


class Waiting(
    Event,
    kind="waiting",
    text="waits[: {why}| for {for:and}| for its turn]",
    changes=Part.WAITING,
    sets={"waits": True},
):
    """A robot waits on its way, for other robots or for something else; told again when that changes."""

    robot: RobotName
    at: Position
    lane: Annotated[LaneName | None, Field(description="The lane that it can't enter; left out off the lanes.")] = None
    why: Annotated[str, Field(description="What is in the way, unless it is a robot.")] = ""
    for_: Annotated[
        tuple[str, ...] | None, Field(description="The robots for which it waits; left out where there is a `why`.")
    ] = None


class WentOn(
    Event,
    kind="went_on",
    severity="debug",
    text="continues after waiting {waited} s",
    changes=Part.WAITING,
    sets={"waits": False},
):
    """A robot that waited continues on its way."""

    robot: RobotName
    waited: Annotated[Number, Field(description="How long it waited, in simulated seconds.")]


class GaveUpWaiting(
    Event,
    kind="gave_up_waiting",
    severity="warning",
    text="gives up after waiting {waited} s: blocked {why}",
    changes=Part.WAITING,
    sets={"waits": False},
):
    """A robot has waited as long as `patience` says while none in its way made progress, and its goal is aborted."""

    robot: RobotName
    at: Position
    waited: Annotated[Number, Field(description="How long it waited, in simulated seconds.")]
    for_: Annotated[tuple[str, ...], Field(description="The robots in its way; none if something else is.")]
    why: Annotated[
        str,
        Field(description="Who is in its way, in which state, where, since when, and why it makes no room."),
    ]


class Rerouted(Event, kind="rerouted", text="takes another route"):
    """A robot that waited takes another route."""

    robot: RobotName
    at: Position


class MadeRoom(Event, kind="made_room", text="moves aside[ for {by}]", changes=Part.YIELDING):
    """A robot leaves its place so that another can pass."""

    robot: RobotName
    from_: Annotated[Position, Field(description="Where it stood: x, y in the world's unit.")]
    to: Annotated[Position, Field(description="Where it goes.")]
    by: Annotated[
        str, Field(description="The robot that wants to pass; left out where it lets others out of its own way.")
    ] = ""


class Deadlock(
    Event, kind="deadlock", severity="warning", subject=(), text="deadlock of {robots:and}", changes=Part.DEADLOCKS
):
    """Robots wait for each other in a circle; the traffic policy moves one of them, or aborts a goal."""

    robots: RobotNames
    lanes: Annotated[tuple[LaneName, ...], Field(description="The lanes that they can't enter.")]


class LaneEvent(Event, subject=("lane",), changes=Part.CLOSED_LANES):
    """A change of a lane."""

    lane: LaneName


class LaneClosed(LaneEvent, kind="lane_closed", severity="warning", text="is closed[: {why}]", sets={"closed": True}):
    """A lane is closed: no robot enters it; a robot that is on it may leave it."""

    why: Annotated[str, Field(description="Why it is closed: all reasons, as text.")]


class LaneOpened(LaneEvent, kind="lane_opened", text="is open again", sets={"closed": False}):
    """A lane is open again."""


EVENTS: Final = EventGroup(
    "traffic", (Waiting, WentOn, GaveUpWaiting, Rerouted, MadeRoom, Deadlock, LaneClosed, LaneOpened)
)
