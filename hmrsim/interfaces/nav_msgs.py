"""Odometry, paths, lists of goals and maps."""

from __future__ import annotations

from pydantic import Field

from hmrsim.interfaces.builtin_interfaces import Time
from hmrsim.interfaces.geometry_msgs import Pose, PoseStamped, PoseWithCovariance, TwistWithCovariance
from hmrsim.interfaces.message import Float32, Int8, Message, String, UInt32
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


class MapMetaData(Message):
    """The size of a map in cells, the length of a cell, and the pose of the corner of the first one."""

    map_load_time: Time = Field(default_factory=Time)
    resolution: Float32 = 0.0
    width: UInt32 = 0
    height: UInt32 = 0
    origin: Pose = Field(default_factory=Pose)


class OccupancyGrid(Message):
    """A map, row by row in +x, rows in +y: 0 is a free cell, 100 an occupied one, -1 an unknown one."""

    header: Header = Field(default_factory=Header)
    info: MapMetaData = Field(default_factory=MapMetaData)
    data: list[Int8] = Field(default_factory=list)


class GetMap:
    """Read the map."""

    class Request(Message):
        """The request, which has no fields."""

    class Response(Message):
        """The map as an occupancy grid."""

        map: OccupancyGrid = Field(default_factory=OccupancyGrid)
