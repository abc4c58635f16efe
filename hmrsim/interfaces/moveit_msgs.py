"""MoveIt's Pickup and Place, and all messages nested in them.

hmrsim reads a few fields of a goal (names, places). It accepts the rest, so that any ROS goal is valid.
"""

from __future__ import annotations

from typing import ClassVar

from pydantic import Field

from hmrsim.interfaces.geometry_msgs import Pose, PoseStamped, Quaternion, TransformStamped, Vector3, Vector3Stamped
from hmrsim.interfaces.message import Bool, Byte, Float32, Float64, Int32, Message, String, UInt8
from hmrsim.interfaces.object_recognition_msgs import ObjectType
from hmrsim.interfaces.octomap_msgs import OctomapWithPose
from hmrsim.interfaces.sensor_msgs import JointState, MultiDOFJointState
from hmrsim.interfaces.shape_msgs import Mesh, Plane, SolidPrimitive
from hmrsim.interfaces.std_msgs import ColorRGBA, Header
from hmrsim.interfaces.trajectory_msgs import JointTrajectory, MultiDOFJointTrajectory


class MoveItErrorCodes(Message):
    """The outcome: *val* is SUCCESS, which is 1, or an error code; *source* names the reporter."""

    UNDEFINED: ClassVar[int] = 0
    SUCCESS: ClassVar[int] = 1
    FAILURE: ClassVar[int] = 99999
    PLANNING_FAILED: ClassVar[int] = -1
    INVALID_MOTION_PLAN: ClassVar[int] = -2
    MOTION_PLAN_INVALIDATED_BY_ENVIRONMENT_CHANGE: ClassVar[int] = -3
    CONTROL_FAILED: ClassVar[int] = -4
    UNABLE_TO_AQUIRE_SENSOR_DATA: ClassVar[int] = -5
    TIMED_OUT: ClassVar[int] = -6
    PREEMPTED: ClassVar[int] = -7
    START_STATE_IN_COLLISION: ClassVar[int] = -10
    START_STATE_VIOLATES_PATH_CONSTRAINTS: ClassVar[int] = -11
    GOAL_IN_COLLISION: ClassVar[int] = -12
    GOAL_VIOLATES_PATH_CONSTRAINTS: ClassVar[int] = -13
    GOAL_CONSTRAINTS_VIOLATED: ClassVar[int] = -14
    INVALID_GROUP_NAME: ClassVar[int] = -15
    INVALID_GOAL_CONSTRAINTS: ClassVar[int] = -16
    INVALID_ROBOT_STATE: ClassVar[int] = -17
    INVALID_LINK_NAME: ClassVar[int] = -18
    INVALID_OBJECT_NAME: ClassVar[int] = -19
    FRAME_TRANSFORM_FAILURE: ClassVar[int] = -21
    COLLISION_CHECKING_UNAVAILABLE: ClassVar[int] = -22
    ROBOT_STATE_STALE: ClassVar[int] = -23
    SENSOR_INFO_STALE: ClassVar[int] = -24
    COMMUNICATION_FAILURE: ClassVar[int] = -25
    START_STATE_INVALID: ClassVar[int] = -26
    GOAL_STATE_INVALID: ClassVar[int] = -27
    UNRECOGNIZED_GOAL_TYPE: ClassVar[int] = -28
    CRASH: ClassVar[int] = -29
    ABORT: ClassVar[int] = -30
    NO_IK_SOLUTION: ClassVar[int] = -31

    val: Int32 = 0
    message: String = ""
    source: String = ""


class JointConstraint(Message):
    """A joint's position and its tolerance to either side."""

    joint_name: String = ""
    position: Float64 = 0.0
    tolerance_above: Float64 = 0.0
    tolerance_below: Float64 = 0.0
    weight: Float64 = 0.0


class BoundingVolume(Message):
    """A region: the union of solids and meshes, each with its pose."""

    primitives: list[SolidPrimitive] = Field(default_factory=list)
    primitive_poses: list[Pose] = Field(default_factory=list)
    meshes: list[Mesh] = Field(default_factory=list)
    mesh_poses: list[Pose] = Field(default_factory=list)


class PositionConstraint(Message):
    """A point of a link and the region in which it must be."""

    header: Header = Field(default_factory=Header)
    link_name: String = ""
    target_point_offset: Vector3 = Field(default_factory=Vector3)
    constraint_region: BoundingVolume = Field(default_factory=BoundingVolume)
    weight: Float64 = 0.0


class OrientationConstraint(Message):
    """A link's orientation and its tolerance in radians."""

    XYZ_EULER_ANGLES: ClassVar[int] = 0
    ROTATION_VECTOR: ClassVar[int] = 1

    header: Header = Field(default_factory=Header)
    orientation: Quaternion = Field(default_factory=Quaternion)
    link_name: String = ""
    absolute_x_axis_tolerance: Float64 = 0.0
    absolute_y_axis_tolerance: Float64 = 0.0
    absolute_z_axis_tolerance: Float64 = 0.0
    parameterization: UInt8 = 0
    weight: Float64 = 0.0


class VisibilityConstraint(Message):
    """A disc that a sensor must see; an angle of 0 radians is not checked."""

    SENSOR_Z: ClassVar[int] = 0
    SENSOR_Y: ClassVar[int] = 1
    SENSOR_X: ClassVar[int] = 2

    target_radius: Float64 = 0.0
    target_pose: PoseStamped = Field(default_factory=PoseStamped)
    cone_sides: Int32 = 0
    sensor_pose: PoseStamped = Field(default_factory=PoseStamped)
    max_view_angle: Float64 = 0.0
    max_range_angle: Float64 = 0.0
    sensor_view_direction: UInt8 = 0
    weight: Float64 = 0.0


class Constraints(Message):
    """Constraints on a state, or on every state of a motion."""

    name: String = ""
    joint_constraints: list[JointConstraint] = Field(default_factory=list)
    position_constraints: list[PositionConstraint] = Field(default_factory=list)
    orientation_constraints: list[OrientationConstraint] = Field(default_factory=list)
    visibility_constraints: list[VisibilityConstraint] = Field(default_factory=list)


class CollisionObject(Message):
    """An object in the planning scene, and whether it is added, removed, extended or moved."""

    ADD: ClassVar[int] = 0
    REMOVE: ClassVar[int] = 1
    APPEND: ClassVar[int] = 2
    MOVE: ClassVar[int] = 3

    header: Header = Field(default_factory=Header)
    pose: Pose = Field(default_factory=Pose)
    id: String = ""
    type: ObjectType = Field(default_factory=ObjectType)
    primitives: list[SolidPrimitive] = Field(default_factory=list)
    primitive_poses: list[Pose] = Field(default_factory=list)
    meshes: list[Mesh] = Field(default_factory=list)
    mesh_poses: list[Pose] = Field(default_factory=list)
    planes: list[Plane] = Field(default_factory=list)
    plane_poses: list[Pose] = Field(default_factory=list)
    subframe_names: list[String] = Field(default_factory=list)
    subframe_poses: list[Pose] = Field(default_factory=list)
    operation: Byte = 0


class AttachedCollisionObject(Message):
    """An object attached to a link; *weight* in kilograms."""

    link_name: String = ""
    object: CollisionObject = Field(default_factory=CollisionObject)
    touch_links: list[String] = Field(default_factory=list)
    detach_posture: JointTrajectory = Field(default_factory=JointTrajectory)
    weight: Float64 = 0.0


class RobotState(Message):
    """A robot's joints and attached objects; a diff changes only the named ones."""

    joint_state: JointState = Field(default_factory=JointState)
    multi_dof_joint_state: MultiDOFJointState = Field(default_factory=MultiDOFJointState)
    attached_collision_objects: list[AttachedCollisionObject] = Field(default_factory=list)
    is_diff: Bool = False


class RobotTrajectory(Message):
    """The motion of all joints of a robot."""

    joint_trajectory: JointTrajectory = Field(default_factory=JointTrajectory)
    multi_dof_joint_trajectory: MultiDOFJointTrajectory = Field(default_factory=MultiDOFJointTrajectory)


class AllowedCollisionEntry(Message):
    """One row of the matrix: whether the link may touch the object of each column."""

    enabled: list[Bool] = Field(default_factory=list)


class AllowedCollisionMatrix(Message):
    """The pairs of named objects that may touch; defaults hold for pairs that the matrix lacks."""

    entry_names: list[String] = Field(default_factory=list)
    entry_values: list[AllowedCollisionEntry] = Field(default_factory=list)
    default_entry_names: list[String] = Field(default_factory=list)
    default_entry_values: list[Bool] = Field(default_factory=list)


class LinkPadding(Message):
    """The padding of a link."""

    link_name: String = ""
    padding: Float64 = 0.0


class LinkScale(Message):
    """The scale of a link."""

    link_name: String = ""
    scale: Float64 = 0.0


class ObjectColor(Message):
    """The color of one object in the scene."""

    id: String = ""
    color: ColorRGBA = Field(default_factory=ColorRGBA)


class PlanningSceneWorld(Message):
    """The parts of the scene that are not part of the robot."""

    collision_objects: list[CollisionObject] = Field(default_factory=list)
    octomap: OctomapWithPose = Field(default_factory=OctomapWithPose)


class PlanningScene(Message):
    """A robot among objects; a diff changes only the named ones."""

    name: String = ""
    robot_state: RobotState = Field(default_factory=RobotState)
    robot_model_name: String = ""
    fixed_frame_transforms: list[TransformStamped] = Field(default_factory=list)
    allowed_collision_matrix: AllowedCollisionMatrix = Field(default_factory=AllowedCollisionMatrix)
    link_padding: list[LinkPadding] = Field(default_factory=list)
    link_scale: list[LinkScale] = Field(default_factory=list)
    object_colors: list[ObjectColor] = Field(default_factory=list)
    world: PlanningSceneWorld = Field(default_factory=PlanningSceneWorld)
    is_diff: Bool = False


class PlanningOptions(Message):
    """Options of planning and of further attempts; *replan_delay* in seconds."""

    planning_scene_diff: PlanningScene = Field(default_factory=PlanningScene)
    plan_only: Bool = False
    look_around: Bool = False
    look_around_attempts: Int32 = 0
    max_safe_execution_cost: Float64 = 0.0
    replan: Bool = False
    replan_attempts: Int32 = 0
    replan_delay: Float64 = 0.0


class GripperTranslation(Message):
    """A straight motion of the gripper: its desired and least length."""

    direction: Vector3Stamped = Field(default_factory=Vector3Stamped)
    desired_distance: Float32 = 0.0
    min_distance: Float32 = 0.0


class Grasp(Message):
    """One way to grasp an object; *max_contact_force* in newtons, 0 for no limit."""

    id: String = ""
    pre_grasp_posture: JointTrajectory = Field(default_factory=JointTrajectory)
    grasp_posture: JointTrajectory = Field(default_factory=JointTrajectory)
    grasp_pose: PoseStamped = Field(default_factory=PoseStamped)
    grasp_quality: Float64 = 0.0
    pre_grasp_approach: GripperTranslation = Field(default_factory=GripperTranslation)
    post_grasp_retreat: GripperTranslation = Field(default_factory=GripperTranslation)
    post_place_retreat: GripperTranslation = Field(default_factory=GripperTranslation)
    max_contact_force: Float32 = 0.0
    allowed_touch_objects: list[String] = Field(default_factory=list)


class PlaceLocation(Message):
    """One place where an object may be put down."""

    id: String = ""
    post_place_posture: JointTrajectory = Field(default_factory=JointTrajectory)
    place_pose: PoseStamped = Field(default_factory=PoseStamped)
    quality: Float64 = 0.0
    pre_place_approach: GripperTranslation = Field(default_factory=GripperTranslation)
    post_place_retreat: GripperTranslation = Field(default_factory=GripperTranslation)
    allowed_touch_objects: list[String] = Field(default_factory=list)


class Pickup:
    """Pick up an object with the gripper."""

    class Goal(Message):
        """The object to pick up; hmrsim uses *target_name*. *allowed_planning_time* in seconds."""

        target_name: String = ""
        group_name: String = ""
        end_effector: String = ""
        possible_grasps: list[Grasp] = Field(default_factory=list)
        support_surface_name: String = ""
        allow_gripper_support_collision: Bool = False
        attached_object_touch_links: list[String] = Field(default_factory=list)
        minimize_object_distance: Bool = False
        path_constraints: Constraints = Field(default_factory=Constraints)
        planner_id: String = ""
        allowed_touch_objects: list[String] = Field(default_factory=list)
        allowed_planning_time: Float64 = 0.0
        planning_options: PlanningOptions = Field(default_factory=PlanningOptions)

    class Result(Message):
        """The outcome, the motion, and the grasp that was used; *planning_time* in seconds."""

        error_code: MoveItErrorCodes = Field(default_factory=MoveItErrorCodes)
        trajectory_start: RobotState = Field(default_factory=RobotState)
        trajectory_stages: list[RobotTrajectory] = Field(default_factory=list)
        trajectory_descriptions: list[String] = Field(default_factory=list)
        grasp: Grasp = Field(default_factory=Grasp)
        planning_time: Float64 = 0.0

    class Feedback(Message):
        """The step that the robot has reached."""

        state: String = ""


class Place:
    """Put down the attached object."""

    class Goal(Message):
        """The object and the place; hmrsim uses *attached_object_name* and *place_locations*."""

        group_name: String = ""
        attached_object_name: String = ""
        place_locations: list[PlaceLocation] = Field(default_factory=list)
        place_eef: Bool = False
        support_surface_name: String = ""
        allow_gripper_support_collision: Bool = False
        path_constraints: Constraints = Field(default_factory=Constraints)
        planner_id: String = ""
        allowed_touch_objects: list[String] = Field(default_factory=list)
        allowed_planning_time: Float64 = 0.0
        planning_options: PlanningOptions = Field(default_factory=PlanningOptions)

    class Result(Message):
        """The outcome, the motion, and the place that was used; *planning_time* in seconds."""

        error_code: MoveItErrorCodes = Field(default_factory=MoveItErrorCodes)
        trajectory_start: RobotState = Field(default_factory=RobotState)
        trajectory_stages: list[RobotTrajectory] = Field(default_factory=list)
        trajectory_descriptions: list[String] = Field(default_factory=list)
        place_location: PlaceLocation = Field(default_factory=PlaceLocation)
        planning_time: Float64 = 0.0

    class Feedback(Message):
        """The step that the robot has reached."""

        state: String = ""
