"""Events of traffic: waiting robots, deadlocks, and closed lanes."""

from __future__ import annotations

from typing import Annotated, Final

from pydantic import Field

from hmrsim.events._event import Event, EventGroup, LaneName, Number, Part, Position, RobotName, RobotNames


class Waiting(
    Event,
    kind="waiting",
    text="waits[: {why}| for {for:and}| for its turn]",
    changes=Part.WAITING,
    sets={"waits": True},
):
    """A robot waits on its route, for other robots or another reason; published again when the reason changes."""

    robot: RobotName
    at: Position
    lane: Annotated[LaneName | None, Field(description="The lane that it can't enter; omitted off the lanes.")] = None
    why: Annotated[str, Field(description="The reason, unless other robots are in the way.")] = ""
    for_: Annotated[
        tuple[str, ...] | None, Field(description="The robots for which it waits; omitted if there is a `why`.")
    ] = None


class WentOn(
    Event,
    kind="went_on",
    severity="debug",
    text="continues after waiting {waited} s",
    changes=Part.WAITING,
    sets={"waits": False},
):
    """A robot that waited continues on its route."""

    robot: RobotName
    waited: Annotated[Number, Field(description="The time that it waited, in simulated seconds.")]


class GaveUpWaiting(
    Event,
    kind="gave_up_waiting",
    severity="warning",
    text="gives up after waiting {waited} s: {why}",
    changes=Part.WAITING,
    sets={"waits": False},
):
    """A robot has waited for its `patience` while the robots in its way made no progress; its goal is aborted."""

    robot: RobotName
    at: Position
    waited: Annotated[Number, Field(description="The time that it waited, in simulated seconds.")]
    for_: Annotated[tuple[str, ...], Field(description="The robots in its way; none if something else is.")]
    why: Annotated[
        str,
        Field(description="The chain of causes, from this robot to the one that starts it, and what would help."),
    ]


class Rerouted(Event, kind="rerouted", text="takes another route"):
    """A robot that waited takes another route."""

    robot: RobotName
    at: Position


class MadeRoom(Event, kind="made_room", text="moves aside[ for {by}]", changes=Part.YIELDING):
    """A robot moves aside so that another can pass."""

    robot: RobotName
    from_: Annotated[Position, Field(description="Its previous position: x, y in the world's unit.")]
    to: Annotated[Position, Field(description="The position to which it moves.")]
    by: Annotated[
        str, Field(description="The robot that wants to pass; omitted if the robot clears its own route.")
    ] = ""


class Deadlock(
    Event, kind="deadlock", severity="warning", subject=(), text="deadlock of {robots:and}", changes=Part.DEADLOCKS
):
    """Robots wait for each other in a circle; the traffic policy moves one of them, or aborts a goal."""

    robots: RobotNames
    lanes: Annotated[tuple[LaneName, ...], Field(description="The lanes that they can't enter.")]


class LaneEvent(Event, subject=("lane",), changes=Part.CLOSED_LANES):
    """An event of a lane."""

    lane: LaneName


class LaneClosed(LaneEvent, kind="lane_closed", severity="warning", text="is closed[: {why}]", sets={"closed": True}):
    """A lane is closed: no robot can enter it, but a robot on it can leave."""

    why: Annotated[str, Field(description="All reasons for the closure, as text.")]


class LaneOpened(LaneEvent, kind="lane_opened", text="is open again", sets={"closed": False}):
    """A lane is open again."""


EVENTS: Final = EventGroup(
    "traffic", (Waiting, WentOn, GaveUpWaiting, Rerouted, MadeRoom, Deadlock, LaneClosed, LaneOpened)
)
