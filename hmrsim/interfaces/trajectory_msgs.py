"""Motions of joints over time."""

from __future__ import annotations

from pydantic import Field

from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.geometry_msgs import Transform, Twist
from hmrsim.interfaces.message import Float64, Message, String
from hmrsim.interfaces.std_msgs import Header


class JointTrajectoryPoint(Message):
    """All joints at one instant, in the order of the trajectory's names."""

    positions: list[Float64] = Field(default_factory=list)
    velocities: list[Float64] = Field(default_factory=list)
    accelerations: list[Float64] = Field(default_factory=list)
    effort: list[Float64] = Field(default_factory=list)
    time_from_start: Duration = Field(default_factory=Duration)


class JointTrajectory(Message):
    """The motion of the named joints."""

    header: Header = Field(default_factory=Header)
    joint_names: list[String] = Field(default_factory=list)
    points: list[JointTrajectoryPoint] = Field(default_factory=list)


class MultiDOFJointTrajectoryPoint(Message):
    """All joints with several degrees of freedom at one instant."""

    transforms: list[Transform] = Field(default_factory=list)
    velocities: list[Twist] = Field(default_factory=list)
    accelerations: list[Twist] = Field(default_factory=list)
    time_from_start: Duration = Field(default_factory=Duration)


class MultiDOFJointTrajectory(Message):
    """The motion of the named joints with several degrees of freedom."""

    header: Header = Field(default_factory=Header)
    joint_names: list[String] = Field(default_factory=list)
    points: list[MultiDOFJointTrajectoryPoint] = Field(default_factory=list)
