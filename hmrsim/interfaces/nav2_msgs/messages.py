"""The messages that Nav2's actions share."""

from __future__ import annotations

from typing import ClassVar

from pydantic import Field

from hmrsim.interfaces.geometry_msgs import Point, PoseStamped
from hmrsim.interfaces.message import Float32, Message, String, UInt8, UInt16, UInt32
from hmrsim.interfaces.std_msgs import Header


class Codes:
    """The codes that mean the same in the result of every action."""

    NONE: ClassVar[int] = 0
    GOAL_REJECTED: ClassVar[int] = 1
    SEND_GOAL_FAILURE: ClassVar[int] = 2


class WaypointStatus(Message):
    """How one waypoint of several fared, by its index in the goal."""

    PENDING: ClassVar[int] = 0
    COMPLETED: ClassVar[int] = 1
    SKIPPED: ClassVar[int] = 2
    FAILED: ClassVar[int] = 3

    waypoint_status: UInt8 = 0
    waypoint_index: UInt32 = 0
    waypoint_pose: PoseStamped = Field(default_factory=PoseStamped)
    error_code: UInt16 = 0
    error_msg: String = ""


class TrackingFeedback(Message):
    """How a robot keeps to its path: errors are positive to the left of it, and where it has to turn left.

    It is of lyrical. The index is that of the pose after which the robot is nearest to the path.
    """

    header: Header = Field(default_factory=Header)
    position_tracking_error: Float32 = 0.0
    heading_tracking_error: Float32 = 0.0
    current_path_index: UInt32 = 0
    robot_pose: PoseStamped = Field(default_factory=PoseStamped)
    distance_to_goal: Float32 = 0.0
    speed: Float32 = 0.0
    remaining_path_length: Float32 = 0.0


class RouteNode(Message):
    """A waypoint of a route, by its number in the route graph."""

    nodeid: UInt16 = 0
    position: Point = Field(default_factory=Point)


class RouteEdge(Message):
    """A lane of a route in its direction, by its number in the route graph."""

    edgeid: UInt16 = 0
    start: Point = Field(default_factory=Point)
    end: Point = Field(default_factory=Point)


class Route(Message):
    """Waypoints in the order in which a robot passes them, and the lanes between them."""

    header: Header = Field(default_factory=Header)
    route_cost: Float32 = 0.0
    nodes: list[RouteNode] = Field(default_factory=list)
    edges: list[RouteEdge] = Field(default_factory=list)
