"""Short motions, waiting and docking."""

from __future__ import annotations

from typing import Annotated, ClassVar

from pydantic import Field

from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.geometry_msgs import Point, PoseStamped
from hmrsim.interfaces.message import Bool, Float32, Message, String, UInt16
from hmrsim.interfaces.nav2_msgs.messages import Codes
from hmrsim.interfaces.quantities import ANGLE, SECONDS, SIGNED_SPEED


class Wait:
    """Stand still for a while."""

    class Goal(Message):
        """How long, in simulated time."""

        time: Duration = Field(default_factory=Duration)

    class Result(Codes, Message):
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

    class Result(Codes, Message):
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

    class Result(Codes, Message):
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

    class Result(Codes, Message):
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

    class Result(Codes, Message):
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

    class Result(Codes, Message):
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
