"""Events of robots: motion, routes, scripts, batteries, docks and the items that they handle."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any, Final

from pydantic import Field

from hmrsim.events._event import Event, EventGroup, LaneName, Number, Part, Position, RobotName, Whole

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

    The event includes the following motions if no decision is due in between.
    """

    robot: RobotName
    from_: Annotated[_Pose, Field(description="The pose where it begins: x, y in the world's unit, yaw in radians.")]
    to: Annotated[_Pose, Field(description="The pose where it ends.")]
    duration: Annotated[Number, Field(description="Simulated seconds.")]
    lane: Annotated[LaneName | None, Field(description="The lane that is driven; null off the lanes.")]
    turned: Annotated[
        Number | None, Field(description="Of a turn in place: radians, counter-clockwise where y is up.")
    ] = None
    ride: Annotated[
        bool, Field(description="Whether it rides in a lift, so that it stays where it began until the ride ends.")
    ] = False
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
            description="The following motions in order, unless another event comes first: each with the same fields, "
            "without `robot`."
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
    """A robot has completed its script or failed."""

    robot: RobotName
    orders: Annotated[Whole, Field(description="The number of orders of the script.")]
    done: Annotated[Whole, Field(description="The number of completed orders.")]
    state: Annotated[str, Field(description="`done` or `failed`.")]
    error: Annotated[str, Field(description="The reason for a failure, else empty.")]


class BatteryEvent(Event, changes=Part.BATTERY):
    """A change of a robot's battery."""

    robot: RobotName
    charge: Annotated[Number, Field(description="The charge, in the world's unit of energy.")]
    percentage: Annotated[Number, Field(description="The share of its capacity that is left, from 0 to 1.")]


class BatteryLow(
    BatteryEvent,
    kind="battery_low",
    severity="warning",
    text="has a low battery ({percentage:percent})",
    sets={"level": "low"},
):
    """A battery has fallen to its low level."""


class BatteryCritical(
    BatteryEvent,
    kind="battery_critical",
    severity="warning",
    text="has a critical battery ({percentage:percent})",
    sets={"level": "critical"},
):
    """A battery has fallen to its critical level."""


class BatteryEmpty(
    BatteryEvent,
    kind="battery_empty",
    severity="error",
    text="has an empty battery",
    sets={"level": "empty", "disables": "battery_empty"},
):
    """A battery is empty, and its robot stops."""

    at: Position


class BatteryRevived(
    BatteryEvent,
    kind="battery_revived",
    text="has power again ({percentage:percent})",
    sets={"level": "", "enables": "battery_empty"},
):
    """An empty battery again has enough charge for its robot to drive."""


class BatteryFull(BatteryEvent, kind="battery_full", text="has a full battery", sets={"level": ""}):
    """A battery is fully charged again."""


class ChargingBegan(
    BatteryEvent, kind="charging_began", text="starts charging ({percentage:percent})", sets={"charging": True}
):
    """A battery is being charged."""


class ChargingEnded(
    BatteryEvent, kind="charging_ended", text="stops charging ({percentage:percent})", sets={"charging": False}
):
    """A battery is no longer being charged."""


class DockEvent(Event, changes=Part.DOCK):
    """An event of a robot at a dock."""

    robot: RobotName
    dock: Annotated[str, Field(description="The dock's name.")]


class DockQueued(
    DockEvent, kind="dock_queued", text="waits in the queue of {dock}, position {position}", sets={"state": "queued"}
):
    """A robot queues because all berths of the dock are taken."""

    position: Annotated[Whole, Field(description="Its place in the queue, from 1.")]


class Docked(DockEvent, kind="dock_docked", text="docked at {dock}", sets={"state": "docked"}):
    """A robot has docked at its dock."""


class Undocked(DockEvent, kind="dock_undocked", text="undocked from {dock}", sets={"state": "away"}):
    """A robot has left its dock."""


class ItemEvent(Event, changes=Part.CARRIER):
    """An event of an item that a robot handles."""

    robot: RobotName
    item: Annotated[str, Field(description="The item's name.")]


class ItemPicked(ItemEvent, kind="picked", text="picks up {item}", sets={"carried": True}):
    """A robot picks up an item."""


class ItemPlaced(ItemEvent, kind="placed", text="puts down {item} at {at:point}", sets={"carried": False}):
    """A robot puts down an item."""

    at: Position


class ItemDropped(
    ItemEvent, kind="dropped", severity="warning", text="drops {item} at {at:point}", sets={"carried": False}
):
    """A robot drops an item, which then blocks its lane."""

    at: Position


ROBOTS: Final = EventGroup("robots", (MotionBegan, RouteTaken, Stopped, ScriptEnded))
BATTERIES: Final = EventGroup(
    "batteries",
    (BatteryLow, BatteryCritical, BatteryEmpty, BatteryRevived, BatteryFull, ChargingBegan, ChargingEnded),
)
DOCKS: Final = EventGroup("docks", (DockQueued, Docked, Undocked))
ITEMS: Final = EventGroup("items", (ItemPicked, ItemPlaced, ItemDropped))
EVENTS: Final = (ROBOTS, BATTERIES, DOCKS, ITEMS)
