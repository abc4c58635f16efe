"""Occupied space, as octrees; hmrsim accepts them and does not look inside."""

from __future__ import annotations

from pydantic import Field

from hmrsim.interfaces.geometry_msgs import Pose
from hmrsim.interfaces.message import Bool, Float64, Int8, Message, String
from hmrsim.interfaces.std_msgs import Header


class Octomap(Message):
    """A serialized octree; *resolution* is the edge of its smallest cell."""

    header: Header = Field(default_factory=Header)
    binary: Bool = False
    id: String = ""
    resolution: Float64 = 0.0
    data: list[Int8] = Field(default_factory=list)


class OctomapWithPose(Message):
    """An octree and the pose of its origin."""

    header: Header = Field(default_factory=Header)
    origin: Pose = Field(default_factory=Pose)
    octomap: Octomap = Field(default_factory=Octomap)
