"""Nav2's actions and their error codes, as of kilted.

A navigator passes on the code of the planner or controller that failed, which is lower than its own codes.
"""

from __future__ import annotations

from typing import Annotated, ClassVar

from pydantic import Field

from hmrsim.interfaces.builtin_interfaces import Duration, Time
from hmrsim.interfaces.geometry_msgs import Point, Pose, PoseStamped
from hmrsim.interfaces.message import Bool, Float32, Float64, Int16, Int32, Message, String, UInt8, UInt16, UInt32
from hmrsim.interfaces.nav_msgs import Goals, Path
from hmrsim.interfaces.quantities import ANGLE, SECONDS, SIGNED_SPEED
from hmrsim.interfaces.std_msgs import Empty, Header


class Codes:
    """Codes with the same meaning in the result of every action."""

    NONE: ClassVar[int] = 0
    GOAL_REJECTED: ClassVar[int] = 1
    SEND_GOAL_FAILURE: ClassVar[int] = 2


class WaypointStatus(Message):
    """The outcome at one of several waypoints, by its index in the goal."""

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
    """The deviation of a robot from its path: positive if it is to the left of the path, or has to turn left.

    Nav2 has this message since lyrical. The robot is nearest to the path after the pose with *current_path_index*.
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


class Wait:
    """Wait in place for a while."""

    class Goal(Message):
        """The simulated time to wait."""

        time: Duration = Field(default_factory=Duration)

    class Result(Codes, Message):
        """The time that passed, and why the action ended early, if it did."""

        UNKNOWN: ClassVar[int] = 740
        TIMEOUT: ClassVar[int] = 741

        total_elapsed_time: Duration = Field(default_factory=Duration)
        error_code: UInt16 = 0
        error_msg: String = ""

    class Feedback(Message):
        """The time that is left."""

        time_left: Duration = Field(default_factory=Duration)


class Spin:
    """Turn on the spot by an angle."""

    class Goal(Message):
        """The angle in radians, counter-clockwise, and the time allowed."""

        target_yaw: Annotated[Float32, ANGLE] = 0.0
        time_allowance: Duration = Field(default_factory=Duration)
        disable_collision_checks: Bool = False

    class Result(Codes, Message):
        """The time that passed, and why the action ended early, if it did."""

        UNKNOWN: ClassVar[int] = 700
        TIMEOUT: ClassVar[int] = 701
        TF_ERROR: ClassVar[int] = 702
        COLLISION_AHEAD: ClassVar[int] = 703

        total_elapsed_time: Duration = Field(default_factory=Duration)
        error_code: UInt16 = 0
        error_msg: String = ""

    class Feedback(Message):
        """The angle turned so far, in radians."""

        angular_distance_traveled: Float32 = 0.0


class BackUp:
    """Drive backwards in a straight line."""

    class Goal(Message):
        """The distance (*target.x*), the speed, and the time allowed."""

        target: Point = Field(default_factory=Point)
        speed: Annotated[Float32, SIGNED_SPEED] = 0.0
        time_allowance: Duration = Field(default_factory=Duration)
        disable_collision_checks: Bool = False

    class Result(Codes, Message):
        """The time that passed, and why the action ended early, if it did."""

        UNKNOWN: ClassVar[int] = 710
        TIMEOUT: ClassVar[int] = 711
        TF_ERROR: ClassVar[int] = 712
        INVALID_INPUT: ClassVar[int] = 713
        COLLISION_AHEAD: ClassVar[int] = 714

        total_elapsed_time: Duration = Field(default_factory=Duration)
        error_code: UInt16 = 0
        error_msg: String = ""

    class Feedback(Message):
        """The distance driven so far."""

        distance_traveled: Float32 = 0.0


class DriveOnHeading:
    """Drive straight ahead for a distance."""

    class Goal(Message):
        """The distance (*target.x*), the speed, and the time allowed."""

        target: Point = Field(default_factory=Point)
        speed: Annotated[Float32, SIGNED_SPEED] = 0.0
        time_allowance: Duration = Field(default_factory=Duration)
        disable_collision_checks: Bool = False

    class Result(Codes, Message):
        """The time that passed, and why the action ended early, if it did."""

        UNKNOWN: ClassVar[int] = 720
        TIMEOUT: ClassVar[int] = 721
        TF_ERROR: ClassVar[int] = 722
        COLLISION_AHEAD: ClassVar[int] = 723
        INVALID_INPUT: ClassVar[int] = 724

        total_elapsed_time: Duration = Field(default_factory=Duration)
        error_code: UInt16 = 0
        error_msg: String = ""

    class Feedback(Message):
        """The distance driven so far."""

        distance_traveled: Float32 = 0.0


class DockRobot:
    """Drive to a dock and charge."""

    class Goal(Message):
        """The dock, by name or by pose; *max_staging_time* is in seconds."""

        use_dock_id: Bool = True
        dock_id: String = ""
        dock_pose: PoseStamped = Field(default_factory=PoseStamped)
        dock_type: String = ""
        max_staging_time: Annotated[Float32, SECONDS] = 1000.0
        navigate_to_staging_pose: Bool = True

    class Result(Codes, Message):
        """The number of retries, and the error if the robot is not docked."""

        DOCK_NOT_IN_DB: ClassVar[int] = 901
        DOCK_NOT_VALID: ClassVar[int] = 902
        FAILED_TO_STAGE: ClassVar[int] = 903
        FAILED_TO_DETECT_DOCK: ClassVar[int] = 904
        FAILED_TO_CONTROL: ClassVar[int] = 905
        FAILED_TO_CHARGE: ClassVar[int] = 906
        TIMEOUT: ClassVar[int] = 907
        UNKNOWN: ClassVar[int] = 999

        success: Bool = True
        error_code: UInt16 = 0
        num_retries: UInt16 = 0
        error_msg: String = ""

    class Feedback(Message):
        """The step that the robot has reached."""

        NONE: ClassVar[int] = 0
        NAV_TO_STAGING_POSE: ClassVar[int] = 1
        INITIAL_PERCEPTION: ClassVar[int] = 2
        CONTROLLING: ClassVar[int] = 3
        WAIT_FOR_CHARGE: ClassVar[int] = 4
        RETRY: ClassVar[int] = 5

        state: UInt16 = 0
        docking_time: Duration = Field(default_factory=Duration)
        num_retries: UInt16 = 0


class UndockRobot:
    """Leave the dock and drive to its staging pose."""

    class Goal(Message):
        """The type of the dock, if the robot can't know it; *max_undocking_time* is in seconds."""

        dock_type: String = ""
        max_undocking_time: Annotated[Float32, SECONDS] = 30.0

    class Result(Codes, Message):
        """The error if the robot has not left its dock."""

        DOCK_NOT_VALID: ClassVar[int] = 902
        FAILED_TO_CONTROL: ClassVar[int] = 905
        TIMEOUT: ClassVar[int] = 907
        UNKNOWN: ClassVar[int] = 999

        success: Bool = True
        error_code: UInt16 = 0
        error_msg: String = ""

    class Feedback(Message):
        """A feedback message without fields."""


class NavigateToPose:
    """Drive to a pose, with replanning."""

    class Goal(Message):
        """The pose; the behavior tree is accepted and not used."""

        pose: PoseStamped = Field(default_factory=PoseStamped)
        behavior_tree: String = ""

    class Result(Codes, Message):
        """Code 0 on success, else one of this action's or its planner's codes."""

        UNKNOWN: ClassVar[int] = 9000
        FAILED_TO_LOAD_BEHAVIOR_TREE: ClassVar[int] = 9001
        TF_ERROR: ClassVar[int] = 9002
        TIMEOUT: ClassVar[int] = 9003

        error_code: UInt16 = 0
        error_msg: String = ""

    class Feedback(Message):
        """The robot's pose and the rest of its route."""

        current_pose: PoseStamped = Field(default_factory=PoseStamped)
        navigation_time: Duration = Field(default_factory=Duration)
        estimated_time_remaining: Duration = Field(default_factory=Duration)
        number_of_recoveries: Int16 = 0
        distance_remaining: Float32 = 0.0


class NavigateThroughPoses:
    """Drive through poses to the last one."""

    class Goal(Message):
        """The poses, in order; the behavior tree is accepted and not used."""

        poses: Goals = Field(default_factory=Goals)
        behavior_tree: String = ""

    class Result(Codes, Message):
        """Code 0 on success, else one of this action's or its planner's codes."""

        UNKNOWN: ClassVar[int] = 9100
        FAILED_TO_LOAD_BEHAVIOR_TREE: ClassVar[int] = 9101
        TF_ERROR: ClassVar[int] = 9102
        TIMEOUT: ClassVar[int] = 9103

        error_code: UInt16 = 0
        error_msg: String = ""
        waypoint_statuses: list[WaypointStatus] = Field(default_factory=list)

    class Feedback(Message):
        """The robot's pose and the rest of its route."""

        current_pose: PoseStamped = Field(default_factory=PoseStamped)
        navigation_time: Duration = Field(default_factory=Duration)
        estimated_time_remaining: Duration = Field(default_factory=Duration)
        number_of_recoveries: Int16 = 0
        distance_remaining: Float32 = 0.0
        number_of_poses_remaining: Int16 = 0
        waypoint_statuses: list[WaypointStatus] = Field(default_factory=list)


class FollowWaypoints:
    """Drive to poses one by one, and skip those that can't be reached."""

    class Goal(Message):
        """The poses, the number of loops, and the index of the first pose."""

        number_of_loops: UInt32 = 0
        goal_index: UInt32 = 0
        poses: list[PoseStamped] = Field(default_factory=list)

    class Result(Message):
        """The waypoints that the robot missed; code 0 even if there are any."""

        NONE: ClassVar[int] = 0
        UNKNOWN: ClassVar[int] = 600
        TASK_EXECUTOR_FAILED: ClassVar[int] = 601
        NO_VALID_WAYPOINTS: ClassVar[int] = 602
        STOP_ON_MISSED_WAYPOINT: ClassVar[int] = 603

        missed_waypoints: list[WaypointStatus] = Field(default_factory=list)
        error_code: UInt16 = 0
        error_msg: String = ""

    class Feedback(Message):
        """The index of the pose to which the robot drives."""

        current_waypoint: UInt32 = 0


class FollowPath:
    """Drive along a given path."""

    class Goal(Message):
        """The path; the ids choose among a controller's plug-ins."""

        path: Path = Field(default_factory=Path)
        controller_id: String = ""
        goal_checker_id: String = ""
        progress_checker_id: String = ""

    class Result(Codes, Message):
        """Code 0 on success, else why the robot stopped."""

        UNKNOWN: ClassVar[int] = 100
        INVALID_CONTROLLER: ClassVar[int] = 101
        TF_ERROR: ClassVar[int] = 102
        INVALID_PATH: ClassVar[int] = 103
        PATIENCE_EXCEEDED: ClassVar[int] = 104
        FAILED_TO_MAKE_PROGRESS: ClassVar[int] = 105
        NO_VALID_CONTROL: ClassVar[int] = 106
        CONTROLLER_TIMED_OUT: ClassVar[int] = 107
        TIMEOUT: ClassVar[int] = 108

        result: Empty = Field(default_factory=Empty)
        error_code: UInt16 = 0
        error_msg: String = ""

    class Feedback(Message):
        """The distance to the end of the path, the speed and, since lyrical, the deviation from the path."""

        distance_to_goal: Float32 = 0.0
        speed: Float32 = 0.0
        tracking_feedback: TrackingFeedback = Field(default_factory=TrackingFeedback)


class ComputePathToPose:
    """Plan a path without driving along it."""

    class Goal(Message):
        """Start and goal; without *use_start* the path starts at the robot's pose."""

        goal: PoseStamped = Field(default_factory=PoseStamped)
        start: PoseStamped = Field(default_factory=PoseStamped)
        planner_id: String = ""
        use_start: Bool = False

    class Result(Codes, Message):
        """The path and the planning time, or why there is no path."""

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
        """A feedback message without fields."""


class ComputePathThroughPoses:
    """Plan a path through poses without driving along it."""

    class Goal(Message):
        """Start and goals; without *use_start* the path starts at the robot's pose."""

        goals: Goals = Field(default_factory=Goals)
        start: PoseStamped = Field(default_factory=PoseStamped)
        planner_id: String = ""
        use_start: Bool = False

    class Result(Codes, Message):
        """The path and the planning time, or why there is no path; *last_reached_index* exists since lyrical."""

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
        """A feedback message without fields."""


class SmoothPath:
    """Smooth a path without driving along it."""

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
        """A feedback message without fields."""


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
        """Start and goal, by poses or by the numbers of waypoints; without *use_start* it starts at the robot."""

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
        """A feedback message without fields."""


class ComputeAndTrackRoute:
    """Find a route on the graph and report the robot's progress along it, whatever drives the robot."""

    class Goal(Message):
        """Start and goal, as in `ComputeRoute`."""

        start_id: UInt16 = 0
        start: PoseStamped = Field(default_factory=PoseStamped)
        goal_id: UInt16 = 0
        goal: PoseStamped = Field(default_factory=PoseStamped)
        use_start: Bool = False
        use_poses: Bool = False

    class Result(_RouteCodes, Message):
        """The time that passed, or why there is no route."""

        OPERATION_FAILED: ClassVar[int] = 406

        execution_duration: Duration = Field(default_factory=Duration)
        error_code: UInt16 = 0
        error_msg: String = ""

    class Feedback(Message):
        """The robot's waypoints and lane (0 for none), and its route and path."""

        last_node_id: UInt16 = 0
        next_node_id: UInt16 = 0
        current_edge_id: UInt16 = 0
        route: Route = Field(default_factory=Route)
        path: Path = Field(default_factory=Path)
        operations_triggered: list[String] = Field(default_factory=list)
        rerouted: Bool = False


class ManageLifecycleNodes:
    """Change the states of all nodes that a lifecycle manager manages."""

    class Request(Message):
        """The transition that all nodes should make."""

        STARTUP: ClassVar[int] = 0
        PAUSE: ClassVar[int] = 1
        RESUME: ClassVar[int] = 2
        RESET: ClassVar[int] = 3
        SHUTDOWN: ClassVar[int] = 4
        CONFIGURE: ClassVar[int] = 5
        CLEANUP: ClassVar[int] = 6

        command: UInt8 = 0

    class Response(Message):
        """The outcome: true if every node made the transition."""

        success: Bool = False


class ClearEntireCostmap:
    """Clear a costmap. Lyrical's request names plugins, and its response has *success*."""

    class Request(Message):
        """The plugins to clear; all if there are none."""

        request: Empty = Field(default_factory=Empty)
        plugins: list[String] = Field(default_factory=list)

    class Response(Message):
        """The outcome: true if the costmap was cleared."""

        response: Empty = Field(default_factory=Empty)
        success: Bool = False


class ClearCostmapExceptRegion:
    """Clear a costmap except for a region around the robot. Lyrical's fields are as in `ClearEntireCostmap`."""

    class Request(Message):
        """The size of the region, and the plugins."""

        reset_distance: Float32 = 0.0
        plugins: list[String] = Field(default_factory=list)

    class Response(Message):
        """The outcome: true if the costmap was cleared."""

        response: Empty = Field(default_factory=Empty)
        success: Bool = False


class ClearCostmapAroundRobot:
    """Clear a costmap around the robot. Lyrical's fields are as in `ClearEntireCostmap`."""

    class Request(Message):
        """The size of the region, and the plugins."""

        reset_distance: Float32 = 0.0
        plugins: list[String] = Field(default_factory=list)

    class Response(Message):
        """The outcome: true if the costmap was cleared."""

        response: Empty = Field(default_factory=Empty)
        success: Bool = False


class CostmapMetaData(Message):
    """The size of a costmap in cells, the length of a cell, and the pose of the corner of the first one."""

    map_load_time: Time = Field(default_factory=Time)
    update_time: Time = Field(default_factory=Time)
    layer: String = ""
    resolution: Float32 = 0.0
    size_x: UInt32 = 0
    size_y: UInt32 = 0
    origin: Pose = Field(default_factory=Pose)


class Costmap(Message):
    """A costmap, row by row in +x, rows in +y: 0 is free, 254 is an obstacle."""

    header: Header = Field(default_factory=Header)
    metadata: CostmapMetaData = Field(default_factory=CostmapMetaData)
    data: list[UInt8] = Field(default_factory=list)


class GetCostmap:
    """Read a costmap."""

    class Request(Message):
        """The requested size, which Nav2 ignores."""

        specs: CostmapMetaData = Field(default_factory=CostmapMetaData)

    class Response(Message):
        """The current costmap, with its metadata."""

        map: Costmap = Field(default_factory=Costmap)


class IsPathValid:
    """Check a path for obstacles. Jazzy's request has only the path, and *success* is lyrical's."""

    class Request(Message):
        """The path, and how to check it."""

        path: Path = Field(default_factory=Path)
        max_cost: UInt8 = 0
        consider_unknown_as_obstacle: Bool = False
        layer_name: String = ""
        footprint: String = ""
        stop_at_first_collision: Bool = False
        max_lookahead_distance: Float64 = 0.0

    class Response(Message):
        """The validity of the path, and the indices of its invalid poses."""

        success: Bool = False
        is_valid: Bool = False
        invalid_pose_indices: list[Int32] = Field(default_factory=list)


class SetRouteGraph:
    """Replace the route graph by that of a file."""

    class Request(Message):
        """The path of the file to read."""

        graph_filepath: String = ""

    class Response(Message):
        """The outcome: true if the file was read."""

        success: Bool = False


class ReloadDockDatabase:
    """Replace the docks by those of a file."""

    class Request(Message):
        """The path of the file to read."""

        filepath: String = ""

    class Response(Message):
        """The outcome: true if the file was read."""

        success: Bool = False
