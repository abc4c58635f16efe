"""Shapes of objects, in their own frames."""

from __future__ import annotations

from typing import Annotated, ClassVar

from pydantic import Field

from hmrsim.interfaces.geometry_msgs import Point, Polygon
from hmrsim.interfaces.message import Array, Float64, Message, UInt8, UInt32


class SolidPrimitive(Message):
    """A simple solid about the origin; *polygon* is the base of a prism."""

    BOX: ClassVar[int] = 1
    SPHERE: ClassVar[int] = 2
    CYLINDER: ClassVar[int] = 3
    CONE: ClassVar[int] = 4
    PRISM: ClassVar[int] = 5

    BOX_X: ClassVar[int] = 0
    BOX_Y: ClassVar[int] = 1
    BOX_Z: ClassVar[int] = 2
    SPHERE_RADIUS: ClassVar[int] = 0
    CYLINDER_HEIGHT: ClassVar[int] = 0
    CYLINDER_RADIUS: ClassVar[int] = 1
    CONE_HEIGHT: ClassVar[int] = 0
    CONE_RADIUS: ClassVar[int] = 1
    PRISM_HEIGHT: ClassVar[int] = 0

    type: UInt8 = 0
    dimensions: Annotated[list[Float64], Array(3, bounded=True), Field(max_length=3)] = Field(default_factory=list)
    polygon: Polygon = Field(default_factory=Polygon)


class MeshTriangle(Message):
    """Three corners, as indices of a mesh's vertices."""

    vertex_indices: Annotated[list[UInt32], Array(3), Field(min_length=3, max_length=3)] = Field(
        default_factory=lambda: [0] * 3
    )


class Mesh(Message):
    """A surface made of triangles."""

    triangles: list[MeshTriangle] = Field(default_factory=list)
    vertices: list[Point] = Field(default_factory=list)


class Plane(Message):
    """The points where a x + b y + c z + d is 0; *coef* is a, b, c, d."""

    coef: Annotated[list[Float64], Array(4), Field(min_length=4, max_length=4)] = Field(
        default_factory=lambda: [0.0] * 4
    )
