"""Driving to poses and along paths."""

from __future__ import annotations

from typing import ClassVar

from pydantic import Field

from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.geometry_msgs import PoseStamped
from hmrsim.interfaces.message import Float32, Int16, Message, String, UInt16, UInt32
from hmrsim.interfaces.nav2_msgs.messages import Codes, TrackingFeedback, WaypointStatus
from hmrsim.interfaces.nav_msgs import Goals, Path
from hmrsim.interfaces.std_msgs import Empty


class NavigateToPose:
    """Drive to a pose."""

    class Goal(Message):
        """Where to; the behaviour tree is accepted and not used."""

        pose: PoseStamped = Field(default_factory=PoseStamped)
        behavior_tree: String = ""

    class Result(Codes, Message):
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

    class Result(Codes, Message):
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


class FollowPath:
    """Drive along a given path."""

    class Goal(Message):
        """The path; the ids choose among a controller's plug-ins."""

        path: Path = Field(default_factory=Path)
        controller_id: String = ""
        goal_checker_id: String = ""
        progress_checker_id: String = ""

    class Result(Codes, Message):
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
        """How far the end is along the path, how fast the robot drives, and, of lyrical, how it keeps to the path."""

        distance_to_goal: Float32 = 0.0
        speed: Float32 = 0.0
        tracking_feedback: TrackingFeedback = Field(default_factory=TrackingFeedback)
