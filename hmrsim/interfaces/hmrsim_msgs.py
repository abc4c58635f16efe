"""Our own services, where ROS has none: what sensors see, what goes wrong, orders, and how a run has ended."""

from __future__ import annotations

from pydantic import Field

from hmrsim.interfaces.builtin_interfaces import Time
from hmrsim.interfaces.geometry_msgs import PoseStamped
from hmrsim.interfaces.message import Bool, Float64, Int32, Message, String, UInt32
from hmrsim.interfaces.simulation_interfaces import Result


class IsDetected:
    """Ask whether the sensors of a robot see another robot or an item."""

    class Request(Message):
        """The robot, and the entity to look for."""

        robot: String = ""
        entity: String = ""

    class Response(Message):
        """Whether it is seen, where, and by which sensors."""

        result: Result = Field(default_factory=Result)
        detected: Bool = False
        pose: PoseStamped = Field(default_factory=PoseStamped)
        by: list[String] = Field(default_factory=list)


class InjectFault:
    """Inject a fault."""

    class Request(Message):
        """What, with the keys of a world file; one that is zero or empty is left out.

        *settings* is JSON text of further keys, for faults that others have added.
        """

        type: String = ""
        name: String = ""
        at: Float64 = 0.0
        until: Float64 = 0.0
        duration: Float64 = 0.0
        mean_time_between: Float64 = 0.0
        mean_duration: Float64 = 0.0
        robot: String = ""
        door: String = ""
        lane: list[String] = Field(default_factory=list)
        sensor: String = ""
        probability: Float64 = 0.0
        factor: Float64 = 0.0
        cells: UInt32 = 0
        dx: Float64 = 0.0
        dy: Float64 = 0.0
        yaw: Float64 = 0.0
        settings: String = ""

    class Response(Message):
        """What came of it, and the name by which it can be cleared."""

        result: Result = Field(default_factory=Result)
        name: String = ""


class ClearFault:
    """Clear faults."""

    class Request(Message):
        """One fault by its name, all of a type, or all."""

        name: String = ""
        type: String = ""

    class Response(Message):
        """What came of it, and the names of those that have ended by it."""

        result: Result = Field(default_factory=Result)
        names: list[String] = Field(default_factory=list)


class Fault(Message):
    """An active or a scheduled fault; *settings* is JSON text, with the keys of a world file."""

    name: String = ""
    type: String = ""
    active: Bool = False
    since: Time = Field(default_factory=Time)
    settings: String = ""


class GetFaults:
    """Ask for the active and the scheduled faults."""

    class Request(Message):
        """Empty."""

    class Response(Message):
        """Those that are known, in the order of their names."""

        result: Result = Field(default_factory=Result)
        faults: list[Fault] = Field(default_factory=list)


class SetDoorState:
    """Set the state of a door."""

    class Request(Message):
        """Which door, and whether it is to be ``open``, ``closed`` (it opens for robots) or ``locked``."""

        name: String = ""
        state: String = ""

    class Response(Message):
        """What came of it; a door takes its time to open."""

        result: Result = Field(default_factory=Result)


class CallLift:
    """Call a lift to a stop."""

    class Request(Message):
        """Which lift, and the waypoint where it is to stop."""

        name: String = ""
        stop: String = ""

    class Response(Message):
        """What came of it; a lift takes its time to come."""

        result: Result = Field(default_factory=Result)


class Order(Message):
    """An order of the demand: an item has to be brought from one place to another.

    *state* is ``waiting``, ``carried``, ``delivered`` or ``lost``; *robot* carries the item, or has brought it; *due*,
    *picked_up* and *ended* are zero where there is none.
    """

    name: String = ""
    demand: String = ""
    item: String = ""
    at: String = ""
    to: String = ""
    priority: Int32 = 0
    state: String = ""
    robot: String = ""
    late: Bool = False
    placed: Time = Field(default_factory=Time)
    due: Time = Field(default_factory=Time)
    picked_up: Time = Field(default_factory=Time)
    ended: Time = Field(default_factory=Time)


class GetOrders:
    """Return the orders of the demand."""

    class Request(Message):
        """Which: *state* ``open``, or one of an order's states; empty for all. Of those that have ended the last."""

        state: String = ""

    class Response(Message):
        """The orders in the order in which they came, and how many there were since the start."""

        result: Result = Field(default_factory=Result)
        orders: list[Order] = Field(default_factory=list)
        placed: UInt32 = 0
        delivered: UInt32 = 0
        late: UInt32 = 0
        lost: UInt32 = 0


class PlaceOrder:
    """Place an order: an item appears at a place, and has to be brought to another."""

    class Request(Message):
        """What, with the keys of a world file's demand; what is zero or empty is left out.

        *name* is that of a kind of orders, which are numbered. *at* and *to* are names of places, docks or waypoints.
        """

        name: String = ""
        item: String = ""
        at: String = ""
        to: String = ""
        within: Float64 = 0.0
        priority: Int32 = 0
        weight: Float64 = 0.0

    class Response(Message):
        """What came of it, and the order."""

        result: Result = Field(default_factory=Result)
        order: Order = Field(default_factory=Order)


class EndRun:
    """Report how a run has ended, for whoever judges it."""

    class Request(Message):
        """A word for how it has ended, and the text of a JSON object with further values, or nothing."""

        label: String = ""
        values: String = ""

    class Response(Message):
        """Whether that could be read."""

        result: Result = Field(default_factory=Result)
