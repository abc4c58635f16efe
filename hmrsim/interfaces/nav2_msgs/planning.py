"""Planning, routing and smoothing."""

from __future__ import annotations

from typing import ClassVar

from pydantic import Field

from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.geometry_msgs import PoseStamped
from hmrsim.interfaces.message import Bool, Int16, Message, String, UInt16
from hmrsim.interfaces.nav2_msgs.messages import Codes, Route
from hmrsim.interfaces.nav_msgs import Goals, Path


class ComputePathToPose:
    """Plan, and don't drive."""

    class Goal(Message):
        """From where to where; *start* counts only with *use_start*, else the robot's pose does."""

        goal: PoseStamped = Field(default_factory=PoseStamped)
        start: PoseStamped = Field(default_factory=PoseStamped)
        planner_id: String = ""
        use_start: Bool = False

    class Result(Codes, Message):
        """The path and how long it took to find, or why there is none."""

        UNKNOWN: ClassVar[int] = 200
        INVALID_PLANNER: ClassVar[int] = 201
        TF_ERROR: ClassVar[int] = 202
        START_OUTSIDE_MAP: ClassVar[int] = 203
        GOAL_OUTSIDE_MAP: ClassVar[int] = 204
        START_OCCUPIED: ClassVar[int] = 205
        GOAL_OCCUPIED: ClassVar[int] = 206
        TIMEOUT: ClassVar[int] = 207
        NO_VALID_PATH: ClassVar[int] = 208

        path: Path = Field(default_factory=Path)
        planning_time: Duration = Field(default_factory=Duration)
        error_code: UInt16 = 0
        error_msg: String = ""

    class Feedback(Message):
        """Nothing."""


class ComputePathThroughPoses:
    """Plan through poses, and don't drive."""

    class Goal(Message):
        """From where, and through what; *start* counts only with *use_start*, else the robot's pose does."""

        goals: Goals = Field(default_factory=Goals)
        start: PoseStamped = Field(default_factory=PoseStamped)
        planner_id: String = ""
        use_start: Bool = False

    class Result(Codes, Message):
        """The path and how long it took to find, or why there is none; *last_reached_index* is of lyrical."""

        ALL_GOALS: ClassVar[int] = -1

        UNKNOWN: ClassVar[int] = 300
        INVALID_PLANNER: ClassVar[int] = 301
        TF_ERROR: ClassVar[int] = 302
        START_OUTSIDE_MAP: ClassVar[int] = 303
        GOAL_OUTSIDE_MAP: ClassVar[int] = 304
        START_OCCUPIED: ClassVar[int] = 305
        GOAL_OCCUPIED: ClassVar[int] = 306
        TIMEOUT: ClassVar[int] = 307
        NO_VALID_PATH: ClassVar[int] = 308
        NO_VIAPOINTS_GIVEN: ClassVar[int] = 309

        path: Path = Field(default_factory=Path)
        last_reached_index: Int16 = -1
        planning_time: Duration = Field(default_factory=Duration)
        error_code: UInt16 = 0
        error_msg: String = ""

    class Feedback(Message):
        """Nothing."""


class SmoothPath:
    """Smooth a path."""

    class Goal(Message):
        """The path; *smoother_id* chooses among a smoother's plug-ins."""

        path: Path = Field(default_factory=Path)
        smoother_id: String = ""
        max_smoothing_duration: Duration = Field(default_factory=Duration)
        check_for_collisions: Bool = False

    class Result(Codes, Message):
        """The smoothed path, or why there is none."""

        UNKNOWN: ClassVar[int] = 500
        INVALID_SMOOTHER: ClassVar[int] = 501
        TIMEOUT: ClassVar[int] = 502
        SMOOTHED_PATH_IN_COLLISION: ClassVar[int] = 503
        FAILED_TO_SMOOTH_PATH: ClassVar[int] = 504
        INVALID_PATH: ClassVar[int] = 505

        path: Path = Field(default_factory=Path)
        smoothing_duration: Duration = Field(default_factory=Duration)
        was_completed: Bool = False
        error_code: UInt16 = 0
        error_msg: String = ""

    class Feedback(Message):
        """Nothing."""


class _RouteCodes(Codes):
    """The codes of Nav2's route server."""

    UNKNOWN: ClassVar[int] = 400
    TF_ERROR: ClassVar[int] = 401
    NO_VALID_GRAPH: ClassVar[int] = 402
    INDETERMINANT_NODES_ON_GRAPH: ClassVar[int] = 403
    TIMEOUT: ClassVar[int] = 404
    NO_VALID_ROUTE: ClassVar[int] = 405
    INVALID_EDGE_SCORER_USE: ClassVar[int] = 407


class ComputeRoute:
    """Find a route on the graph."""

    class Goal(Message):
        """From where to where, by poses or by the numbers of waypoints; without *use_start* from the robot's pose."""

        start_id: UInt16 = 0
        start: PoseStamped = Field(default_factory=PoseStamped)
        goal_id: UInt16 = 0
        goal: PoseStamped = Field(default_factory=PoseStamped)
        use_start: Bool = False
        use_poses: Bool = False

    class Result(_RouteCodes, Message):
        """The route and the path along it, or why there is none."""

        planning_time: Duration = Field(default_factory=Duration)
        path: Path = Field(default_factory=Path)
        route: Route = Field(default_factory=Route)
        error_code: UInt16 = 0
        error_msg: String = ""

    class Feedback(Message):
        """Nothing."""


class ComputeAndTrackRoute:
    """Find a route on the graph, and tell how the robot gets on along it, whatever drives it."""

    class Goal(Message):
        """From where to where, as `ComputeRoute` takes it."""

        start_id: UInt16 = 0
        start: PoseStamped = Field(default_factory=PoseStamped)
        goal_id: UInt16 = 0
        goal: PoseStamped = Field(default_factory=PoseStamped)
        use_start: Bool = False
        use_poses: Bool = False

    class Result(_RouteCodes, Message):
        """How long it took, or why there is no route."""

        OPERATION_FAILED: ClassVar[int] = 406

        execution_duration: Duration = Field(default_factory=Duration)
        error_code: UInt16 = 0
        error_msg: String = ""

    class Feedback(Message):
        """The waypoints and the lane where the robot is, 0 for none, and the route and the path that it is to take."""

        last_node_id: UInt16 = 0
        next_node_id: UInt16 = 0
        current_edge_id: UInt16 = 0
        route: Route = Field(default_factory=Route)
        path: Path = Field(default_factory=Path)
        operations_triggered: list[String] = Field(default_factory=list)
        rerouted: Bool = False
