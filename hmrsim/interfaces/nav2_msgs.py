"""Nav2's actions, as of kilted, and their error codes.

A lower code is a deeper cause: a navigator passes on the planner's or the controller's instead of its own.
"""

from __future__ import annotations

from typing import Annotated, ClassVar

from pydantic import Field

from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.geometry_msgs import Point, PoseStamped
from hmrsim.interfaces.message import Bool, Float32, Int16, Message, String, UInt8, UInt16, UInt32
from hmrsim.interfaces.nav_msgs import Goals, Path
from hmrsim.interfaces.std_msgs import Empty
from hmrsim.quantities import ANGLE, SECONDS, SIGNED_SPEED


class _Codes:
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


class NavigateToPose:
    """Drive to a pose."""

    class Goal(Message):
        """Where to; the behaviour tree is accepted and not used."""

        pose: PoseStamped = Field(default_factory=PoseStamped)
        behavior_tree: String = ""

    class Result(_Codes, Message):
        """Code 0 when it went well, else one of this action's or its planner's codes."""

        UNKNOWN: ClassVar[int] = 9000
        FAILED_TO_LOAD_BEHAVIOR_TREE: ClassVar[int] = 9001
        TF_ERROR: ClassVar[int] = 9002
        TIMEOUT: ClassVar[int] = 9003

        error_code: UInt16 = 0
        error_msg: String = ""

    class Feedback(Message):
        """Where the robot is and how far it still has to go along its route."""

        current_pose: PoseStamped = Field(default_factory=PoseStamped)
        navigation_time: Duration = Field(default_factory=Duration)
        estimated_time_remaining: Duration = Field(default_factory=Duration)
        number_of_recoveries: Int16 = 0
        distance_remaining: Float32 = 0.0


class NavigateThroughPoses:
    """Drive through poses to the last one."""

    class Goal(Message):
        """Where to, in order; the behaviour tree is accepted and not used."""

        poses: Goals = Field(default_factory=Goals)
        behavior_tree: String = ""

    class Result(_Codes, Message):
        """Code 0 when it went well, else one of this action's or its planner's codes."""

        UNKNOWN: ClassVar[int] = 9100
        FAILED_TO_LOAD_BEHAVIOR_TREE: ClassVar[int] = 9101
        TF_ERROR: ClassVar[int] = 9102
        TIMEOUT: ClassVar[int] = 9103

        error_code: UInt16 = 0
        error_msg: String = ""
        waypoint_statuses: list[WaypointStatus] = Field(default_factory=list)

    class Feedback(Message):
        """Where the robot is and what it still has before it."""

        current_pose: PoseStamped = Field(default_factory=PoseStamped)
        navigation_time: Duration = Field(default_factory=Duration)
        estimated_time_remaining: Duration = Field(default_factory=Duration)
        number_of_recoveries: Int16 = 0
        distance_remaining: Float32 = 0.0
        number_of_poses_remaining: Int16 = 0
        waypoint_statuses: list[WaypointStatus] = Field(default_factory=list)


class FollowWaypoints:
    """Drive to poses one by one, and go on when one can't be reached."""

    class Goal(Message):
        """Where to, how often to begin again, and the index of the first pose."""

        number_of_loops: UInt32 = 0
        goal_index: UInt32 = 0
        poses: list[PoseStamped] = Field(default_factory=list)

    class Result(Message):
        """The waypoints that were not reached; code 0 also when there are some."""

        NONE: ClassVar[int] = 0
        UNKNOWN: ClassVar[int] = 600
        TASK_EXECUTOR_FAILED: ClassVar[int] = 601
        NO_VALID_WAYPOINTS: ClassVar[int] = 602
        STOP_ON_MISSED_WAYPOINT: ClassVar[int] = 603

        missed_waypoints: list[WaypointStatus] = Field(default_factory=list)
        error_code: UInt16 = 0
        error_msg: String = ""

    class Feedback(Message):
        """The index of the pose that the robot drives to."""

        current_waypoint: UInt32 = 0


class ComputePathToPose:
    """Plan, and don't drive."""

    class Goal(Message):
        """From where to where; *start* counts only with *use_start*, else the robot's pose does."""

        goal: PoseStamped = Field(default_factory=PoseStamped)
        start: PoseStamped = Field(default_factory=PoseStamped)
        planner_id: String = ""
        use_start: Bool = False

    class Result(_Codes, Message):
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


class FollowPath:
    """Drive along a given path."""

    class Goal(Message):
        """The path; the ids choose among a controller's plug-ins."""

        path: Path = Field(default_factory=Path)
        controller_id: String = ""
        goal_checker_id: String = ""
        progress_checker_id: String = ""

    class Result(_Codes, Message):
        """Code 0 when it went well, else why the robot stopped."""

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
        """How far the end is along the path, and how fast the robot drives."""

        distance_to_goal: Float32 = 0.0
        speed: Float32 = 0.0


class Wait:
    """Stand still for a while."""

    class Goal(Message):
        """How long, in simulated time."""

        time: Duration = Field(default_factory=Duration)

    class Result(_Codes, Message):
        """How long it took, and why it ended early if it did."""

        UNKNOWN: ClassVar[int] = 740
        TIMEOUT: ClassVar[int] = 741

        total_elapsed_time: Duration = Field(default_factory=Duration)
        error_code: UInt16 = 0
        error_msg: String = ""

    class Feedback(Message):
        """How long is left."""

        time_left: Duration = Field(default_factory=Duration)


class Spin:
    """Turn on the spot."""

    class Goal(Message):
        """By how many radians, counter-clockwise, and how long that may take."""

        target_yaw: Annotated[Float32, ANGLE] = 0.0
        time_allowance: Duration = Field(default_factory=Duration)
        disable_collision_checks: Bool = False

    class Result(_Codes, Message):
        """How long it took, and why it ended early if it did."""

        UNKNOWN: ClassVar[int] = 700
        TIMEOUT: ClassVar[int] = 701
        TF_ERROR: ClassVar[int] = 702
        COLLISION_AHEAD: ClassVar[int] = 703

        total_elapsed_time: Duration = Field(default_factory=Duration)
        error_code: UInt16 = 0
        error_msg: String = ""

    class Feedback(Message):
        """Radians turned so far."""

        angular_distance_traveled: Float32 = 0.0


class BackUp:
    """Drive backwards in a straight line."""

    class Goal(Message):
        """How far (*target.x*), how fast, and how long that may take."""

        target: Point = Field(default_factory=Point)
        speed: Annotated[Float32, SIGNED_SPEED] = 0.0
        time_allowance: Duration = Field(default_factory=Duration)
        disable_collision_checks: Bool = False

    class Result(_Codes, Message):
        """How long it took, and why it ended early if it did."""

        UNKNOWN: ClassVar[int] = 710
        TIMEOUT: ClassVar[int] = 711
        TF_ERROR: ClassVar[int] = 712
        INVALID_INPUT: ClassVar[int] = 713
        COLLISION_AHEAD: ClassVar[int] = 714

        total_elapsed_time: Duration = Field(default_factory=Duration)
        error_code: UInt16 = 0
        error_msg: String = ""

    class Feedback(Message):
        """How far the robot has come."""

        distance_traveled: Float32 = 0.0


class DriveOnHeading:
    """Drive straight ahead."""

    class Goal(Message):
        """How far (*target.x*), how fast, and how long that may take."""

        target: Point = Field(default_factory=Point)
        speed: Annotated[Float32, SIGNED_SPEED] = 0.0
        time_allowance: Duration = Field(default_factory=Duration)
        disable_collision_checks: Bool = False

    class Result(_Codes, Message):
        """How long it took, and why it ended early if it did."""

        UNKNOWN: ClassVar[int] = 720
        TIMEOUT: ClassVar[int] = 721
        TF_ERROR: ClassVar[int] = 722
        COLLISION_AHEAD: ClassVar[int] = 723
        INVALID_INPUT: ClassVar[int] = 724

        total_elapsed_time: Duration = Field(default_factory=Duration)
        error_code: UInt16 = 0
        error_msg: String = ""

    class Feedback(Message):
        """How far the robot has come."""

        distance_traveled: Float32 = 0.0


class DockRobot:
    """Drive to a dock and charge."""

    class Goal(Message):
        """Which dock, by name or by pose; *max_staging_time* in seconds."""

        use_dock_id: Bool = True
        dock_id: String = ""
        dock_pose: PoseStamped = Field(default_factory=PoseStamped)
        dock_type: String = ""
        max_staging_time: Annotated[Float32, SECONDS] = 1000.0
        navigate_to_staging_pose: Bool = True

    class Result(_Codes, Message):
        """Whether the robot is docked, after how many retries, and why not."""

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
        """How far the docking has come."""

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
    """Leave the dock."""

    class Goal(Message):
        """What kind of dock it is, if the robot can't know; *max_undocking_time* in seconds."""

        dock_type: String = ""
        max_undocking_time: Annotated[Float32, SECONDS] = 30.0

    class Result(_Codes, Message):
        """Whether the robot has left its dock, and why not."""

        DOCK_NOT_VALID: ClassVar[int] = 902
        FAILED_TO_CONTROL: ClassVar[int] = 905
        TIMEOUT: ClassVar[int] = 907
        UNKNOWN: ClassVar[int] = 999

        success: Bool = True
        error_code: UInt16 = 0
        error_msg: String = ""

    class Feedback(Message):
        """Nothing."""
