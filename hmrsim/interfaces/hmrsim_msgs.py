"""Services of hmrsim for which ROS has none: detection, faults, velocities, doors, lifts, orders, outcomes of runs."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from hmrsim.interfaces.builtin_interfaces import Time
from hmrsim.interfaces.geometry_msgs import PoseStamped
from hmrsim.interfaces.message import Bool, Float64, Int32, Message, String, UInt32
from hmrsim.interfaces.quantities import ANGLE, SIGNED_SPEED
from hmrsim.interfaces.simulation_interfaces import Result


class IsDetected:
    """Check whether the sensors of a robot see another robot or an item."""

    class Request(Message):
        """The robot, and the entity to look for."""

        robot: String = ""
        entity: String = ""

    class Response(Message):
        """The entity's pose and the sensors that see it, if the robot detects it."""

        result: Result = Field(default_factory=Result)
        detected: Bool = False
        pose: PoseStamped = Field(default_factory=PoseStamped)
        by: list[String] = Field(default_factory=list)


class InjectFault:
    """Inject a fault now or at a later time."""

    class Request(Message):
        """The fault, with the keys of a world file. Fields that are zero or empty are left out.

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
        """The result, and the name by which the fault can be cleared."""

        result: Result = Field(default_factory=Result)
        name: String = ""


class ClearFault:
    """Clear faults."""

    class Request(Message):
        """The faults: one by its name, all of a type, or all."""

        name: String = ""
        type: String = ""

    class Response(Message):
        """The result, and the names of the cleared faults."""

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
    """List the active and the scheduled faults."""

    class Request(Message):
        """The request, which has no fields."""

    class Response(Message):
        """The known faults, sorted by name."""

        result: Result = Field(default_factory=Result)
        faults: list[Fault] = Field(default_factory=list)


class SetVelocity:
    """Move a robot at velocities for half a second, as on the topic ``cmd_vel`` of ROS."""

    class Request(Message):
        """The robot, its speed ahead (negative: backwards) in units a second, and its turning rate in rad/s."""

        robot: String = ""
        linear: Annotated[Float64, SIGNED_SPEED] = 0.0
        angular: Annotated[Float64, ANGLE] = 0.0

    class Response(Message):
        """The result; a robot that meets an obstacle stops before it."""

        result: Result = Field(default_factory=Result)


class SetDoorState:
    """Set the state of a door."""

    class Request(Message):
        """The door and its new state: ``open``, ``closed`` (it opens for robots) or ``locked``."""

        name: String = ""
        state: String = ""

    class Response(Message):
        """The result; the door then takes its time to open."""

        result: Result = Field(default_factory=Result)


class CallLift:
    """Call a lift to a stop."""

    class Request(Message):
        """The lift, and the waypoint of the stop."""

        name: String = ""
        stop: String = ""

    class Response(Message):
        """The result; the lift then takes its time to arrive."""

        result: Result = Field(default_factory=Result)


class Order(Message):
    """An order of the demand: to bring an item from one place to another.

    *weight* is the mass of the item in kg. *state* is ``waiting``, ``carried``, ``delivered`` or ``lost``; *robot*
    carries the item, or has brought it; *due*, *picked_up* and *ended* are zero where there is none.
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
    weight: Float64 = 0.0


class GetOrders:
    """Return the orders of the demand."""

    class Request(Message):
        """The state of the orders: ``open``, or one of an order's states; empty for all."""

        state: String = ""

    class Response(Message):
        """The orders, oldest first (of ended orders only the last), and the number of orders since the start."""

        result: Result = Field(default_factory=Result)
        orders: list[Order] = Field(default_factory=list)
        placed: UInt32 = 0
        delivered: UInt32 = 0
        late: UInt32 = 0
        lost: UInt32 = 0


class PlaceOrder:
    """Place an order: an item appears at one place, to be brought to another."""

    class Request(Message):
        """The order, with the keys of a world file's demand. Fields that are zero or empty are left out.

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
        """The result and the order."""

        result: Result = Field(default_factory=Result)
        order: Order = Field(default_factory=Order)


class EndRun:
    """Report the outcome of a run to the program that judges it."""

    class Request(Message):
        """The outcome as a word, and an optional JSON object with further values, as text."""

        label: String = ""
        values: String = ""

    class Response(Message):
        """The result: an error if the outcome could not be read."""

        result: Result = Field(default_factory=Result)
