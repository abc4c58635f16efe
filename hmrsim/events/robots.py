"""Robots that drive, stop and carry out their scripts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any, Final

from pydantic import Field

from hmrsim.events._event import Event, EventGroup
from hmrsim.events._fields import LaneName, Number, Position, RobotName, Whole
from hmrsim.events._parts import Part

_Pose = tuple[Number, Number, Number]


class MotionBegan(
    Event,
    kind="motion",
    severity="debug",
    text="[{ride=true}rides to {to:point}|turns by {turned} rad|drives to {to:point}]",
    traced=False,
    changes=Part.MOTION,
):
    """A robot begins to drive a lane or another straight segment, to turn in place, or to ride in a lift.

    Where nothing is to be decided in between, it tells of the following ones, too.
    """

    robot: RobotName
    from_: Annotated[_Pose, Field(description="The pose where it begins: x, y in the world's unit, yaw in radians.")]
    to: Annotated[_Pose, Field(description="The pose where it ends.")]
    duration: Annotated[Number, Field(description="Simulated seconds.")]
    lane: Annotated[LaneName | None, Field(description="The lane that is driven; null off the lanes.")]
    turned: Annotated[
        Number | None, Field(description="Of a turn in place: radians, counter-clockwise where y is up.")
    ] = None
    ride: Annotated[bool, Field(description="Whether a lift carries it, so that it is where it began until then.")] = (
        False
    )
    profile: Annotated[
        tuple[Number, Number, Number, Number] | None,
        Field(
            description="Where the speed is not constant: distance from rest to rest, greatest speed, acceleration, "
            "and how much of the distance lies before this piece."
        ),
    ] = None
    then: Annotated[
        tuple[dict[str, Any], ...],
        Field(
            description="What it does after that, one after the other, unless another event comes first: each with "
            "fields as these, without `robot`."
        ),
    ] = ()


class RouteTaken(
    Event, kind="route", severity="debug", text="takes a route[ to {points:end}]", traced=False, changes=Part.ROUTE
):
    """A robot sets out on a route."""

    robot: RobotName
    points: Annotated[
        Sequence[tuple[Number, Number]],
        Field(description="The points of the route in order: x, y in the world's unit."),
    ]


class Stopped(Event, kind="stopped", severity="debug", text="stops at {at:point}", changes=Part.POSE):
    """A robot stops before the end of its route."""

    robot: RobotName
    at: Position


class ScriptEnded(
    Event,
    kind="script_ended",
    severity="[{state=failed}error|info]",
    text="[{state=failed}fails its script: {error}|finishes its script ({done} of {orders} orders)]",
    changes=Part.SCRIPT,
):
    """A robot has finished its script, or failed it."""

    robot: RobotName
    orders: Annotated[Whole, Field(description="How many orders the script has.")]
    done: Annotated[Whole, Field(description="How many of them are carried out.")]
    state: Annotated[str, Field(description="`done` or `failed`.")]
    error: Annotated[str, Field(description="Why it failed; else empty.")]


EVENTS: Final = EventGroup("robots", (MotionBegan, RouteTaken, Stopped, ScriptEnded))
