"""Markers to be drawn by RViz and Foxglove."""

from __future__ import annotations

from typing import ClassVar

from pydantic import Field

from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.geometry_msgs import Point, Pose, Vector3
from hmrsim.interfaces.message import Bool, Float32, Int32, Message, String, UInt8
from hmrsim.interfaces.sensor_msgs import CompressedImage
from hmrsim.interfaces.std_msgs import ColorRGBA, Header


class UVCoordinate(Message):
    """A position in a texture; both from 0 to 1."""

    u: Float32 = 0.0
    v: Float32 = 0.0


class MeshFile(Message):
    """The contents of a mesh file."""

    filename: String = ""
    data: list[UInt8] = Field(default_factory=list)


class Marker(Message):
    """An object to be drawn; namespace and id name it, and *action* adds, changes or deletes it."""

    ARROW: ClassVar[int] = 0
    CUBE: ClassVar[int] = 1
    SPHERE: ClassVar[int] = 2
    CYLINDER: ClassVar[int] = 3
    LINE_STRIP: ClassVar[int] = 4
    LINE_LIST: ClassVar[int] = 5
    CUBE_LIST: ClassVar[int] = 6
    SPHERE_LIST: ClassVar[int] = 7
    POINTS: ClassVar[int] = 8
    TEXT_VIEW_FACING: ClassVar[int] = 9
    MESH_RESOURCE: ClassVar[int] = 10
    TRIANGLE_LIST: ClassVar[int] = 11
    ARROW_STRIP: ClassVar[int] = 12

    ADD: ClassVar[int] = 0
    MODIFY: ClassVar[int] = 0
    DELETE: ClassVar[int] = 2
    DELETEALL: ClassVar[int] = 3

    header: Header = Field(default_factory=Header)
    ns: String = ""
    id: Int32 = 0
    type: Int32 = 0
    action: Int32 = 0
    pose: Pose = Field(default_factory=Pose)
    scale: Vector3 = Field(default_factory=Vector3)
    color: ColorRGBA = Field(default_factory=ColorRGBA)
    lifetime: Duration = Field(default_factory=Duration)
    frame_locked: Bool = False
    points: list[Point] = Field(default_factory=list)
    colors: list[ColorRGBA] = Field(default_factory=list)
    texture_resource: String = ""
    texture: CompressedImage = Field(default_factory=CompressedImage)
    uv_coordinates: list[UVCoordinate] = Field(default_factory=list)
    text: String = ""
    mesh_resource: String = ""
    mesh_file: MeshFile = Field(default_factory=MeshFile)
    mesh_use_embedded_materials: Bool = False


class MarkerArray(Message):
    """Objects to be drawn at once."""

    markers: list[Marker] = Field(default_factory=list)
