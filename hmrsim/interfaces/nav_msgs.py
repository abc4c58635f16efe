"""Odometry, paths and lists of goals."""

from __future__ import annotations

from pydantic import Field

from hmrsim.interfaces.geometry_msgs import PoseStamped, PoseWithCovariance, TwistWithCovariance
from hmrsim.interfaces.message import Message, String
from hmrsim.interfaces.std_msgs import Header


class Odometry(Message):
    """A robot's pose in the header's frame and its velocity in its own, the child frame."""

    header: Header = Field(default_factory=Header)
    child_frame_id: String = ""
    pose: PoseWithCovariance = Field(default_factory=PoseWithCovariance)
    twist: TwistWithCovariance = Field(default_factory=TwistWithCovariance)


class Path(Message):
    """Poses in the order in which a robot passes them."""

    header: Header = Field(default_factory=Header)
    poses: list[PoseStamped] = Field(default_factory=list)


class Goals(Message):
    """Poses to be reached one after the other."""

    header: Header = Field(default_factory=Header)
    goals: list[PoseStamped] = Field(default_factory=list)
