"""Points, poses, velocities and forces."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from hmrsim.interfaces.message import Array, Float32, Float64, Message, String
from hmrsim.interfaces.quantities import ROTATION
from hmrsim.interfaces.std_msgs import Header

_COVARIANCE_SIZE = 36

_Rotation = Annotated[Float64, ROTATION]

Covariance = Annotated[
    list[Float64], Array(_COVARIANCE_SIZE), Field(min_length=_COVARIANCE_SIZE, max_length=_COVARIANCE_SIZE)
]
"""A 6 by 6 matrix, row by row; the axes are x, y, z and the rotations about them."""


def _no_covariance() -> list[float]:
    return [0.0] * _COVARIANCE_SIZE


class Point(Message):
    """A position in the world's length unit."""

    x: Float64 = 0.0
    y: Float64 = 0.0
    z: Float64 = 0.0


class Point32(Message):
    """A position in single precision."""

    x: Float32 = 0.0
    y: Float32 = 0.0
    z: Float32 = 0.0


class Polygon(Message):
    """An area by its corners; the last one is joined to the first."""

    points: list[Point32] = Field(default_factory=list)


class PolygonStamped(Message):
    """An area with its frame and time."""

    header: Header = Field(default_factory=Header)
    polygon: Polygon = Field(default_factory=Polygon)


class Vector3(Message):
    """A direction or a velocity."""

    x: Float64 = 0.0
    y: Float64 = 0.0
    z: Float64 = 0.0


class Vector3Stamped(Message):
    """A direction with its frame and time."""

    header: Header = Field(default_factory=Header)
    vector: Vector3 = Field(default_factory=Vector3)


class Quaternion(Message):
    """An orientation; the default is no rotation."""

    x: _Rotation = 0.0
    y: _Rotation = 0.0
    z: _Rotation = 0.0
    w: _Rotation = 1.0


class Pose(Message):
    """A position and an orientation."""

    position: Point = Field(default_factory=Point)
    orientation: Quaternion = Field(default_factory=Quaternion)


class PoseStamped(Message):
    """A pose with its frame and time."""

    header: Header = Field(default_factory=Header)
    pose: Pose = Field(default_factory=Pose)


class PoseWithCovariance(Message):
    """A pose and its covariance."""

    pose: Pose = Field(default_factory=Pose)
    covariance: Covariance = Field(default_factory=_no_covariance)


class PoseWithCovarianceStamped(Message):
    """A pose and its covariance, with frame and time."""

    header: Header = Field(default_factory=Header)
    pose: PoseWithCovariance = Field(default_factory=PoseWithCovariance)


class Transform(Message):
    """The translation and rotation from one frame to another."""

    translation: Vector3 = Field(default_factory=Vector3)
    rotation: Quaternion = Field(default_factory=Quaternion)


class TransformStamped(Message):
    """A transform from the header's frame to a child frame, with its time."""

    header: Header = Field(default_factory=Header)
    child_frame_id: String = ""
    transform: Transform = Field(default_factory=Transform)


class Twist(Message):
    """Linear velocity, and angular velocity in radians per second."""

    linear: Vector3 = Field(default_factory=Vector3)
    angular: Vector3 = Field(default_factory=Vector3)


class TwistStamped(Message):
    """A velocity with its frame and time."""

    header: Header = Field(default_factory=Header)
    twist: Twist = Field(default_factory=Twist)


class TwistWithCovariance(Message):
    """A velocity and its covariance."""

    twist: Twist = Field(default_factory=Twist)
    covariance: Covariance = Field(default_factory=_no_covariance)


class Accel(Message):
    """Linear acceleration, and angular acceleration in radians per second squared."""

    linear: Vector3 = Field(default_factory=Vector3)
    angular: Vector3 = Field(default_factory=Vector3)


class Wrench(Message):
    """Force in newtons and torque in newton meters."""

    force: Vector3 = Field(default_factory=Vector3)
    torque: Vector3 = Field(default_factory=Vector3)
