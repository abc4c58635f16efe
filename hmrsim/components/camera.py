"""A camera: sees the robots and items before it that no wall hides."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from pydantic import Field

from hmrsim.components import Component, Sensor, SensorSettings
from hmrsim.geometry import SAME_PLACE, distance, heading, turn

if TYPE_CHECKING:
    from hmrsim.geometry import Point, Pose

_EDGE = 1e-9
"""Radians beyond the edge of the field of view that still count as inside."""


class CameraSettings(SensorSettings):
    """The range and field of view of a camera.

    Attributes:
        range: Range, from the robot's center to that of the detected entity; None for 10 m, or 800 px.
        resolution: Distance a detected entity has to move before it is published again; None for 0.1 m, or 8 px.
        field_of_view: Horizontal field of view in radians, half of it to either side of the robot's heading.
    """

    field_of_view: Annotated[float, Field(strict=True, gt=0, le=math.tau)] = math.pi / 2


@dataclass(eq=False)
class Camera(Sensor):
    """A camera that a robot carries."""

    default_range = 10.0

    def faces(self, here: Pose, there: Point) -> bool:
        """Return whether a point is before it."""
        if distance(here.point, there) <= SAME_PLACE:
            return True
        half: float = self.settings.field_of_view / 2
        return abs(turn(here.yaw, heading(here.point, there))) <= half + _EDGE


COMPONENT = Component(name="camera", settings=CameraSettings, create=Camera)
