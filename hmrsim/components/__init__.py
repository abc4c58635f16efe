"""Components that robots can carry, one per file, and the base of sensors.

World files name them, robots are built with them, and actions ask for them.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from pydantic import BaseModel, ConfigDict, Field

from hmrsim.geometry import METER, distance
from hmrsim.plugins import discover

if TYPE_CHECKING:
    from hmrsim.geometry import Point, Pose


class Settings(BaseModel):
    """The settings of a component in a world file: unknown keys, NaN and infinity are errors."""

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True, allow_inf_nan=False)


@dataclass(frozen=True)
class Component:
    """A kind of component that robots can carry.

    Attributes:
        name: As in world files, and that of its module.
        settings: The model of its settings.
        create: Makes the component of one robot from its settings.
    """

    name: str
    settings: type[Settings]
    create: Any


@cache
def registry() -> dict[str, Component]:
    """Return all components by name."""
    return discover(sys.modules[__name__], "COMPONENT", Component)


_RESOLUTION = 0.1
"""Meters that a detected entity has to move before it is published again, where a sensor's settings say nothing."""


class SensorSettings(Settings):
    """The settings that all sensors share.

    Attributes:
        range: Range in the world's unit, from the robot's center to that of the detected entity.
        resolution: Distance a detected entity has to move before it is published again; None for 0.1 m, or 8 px.
    """

    range: Annotated[float, Field(strict=True, gt=0, le=1e9)] | None = None
    resolution: Annotated[float, Field(strict=True, ge=0, le=1e9)] | None = None


@dataclass(eq=False)
class Sensor:
    """A sensor that a robot carries."""

    settings: Any
    blind: bool = False

    default_range: ClassVar[float]
    """How far one sees of which nothing is said, in meters."""

    @property
    def through_walls(self) -> bool:
        """Return whether the sensor detects items through walls and doors."""
        return False

    def set_blind(self, *, blind: bool) -> None:
        """Make the sensor see nothing, or see again."""
        self.blind = blind

    def range(self, units: str) -> float:
        """Return how far it sees, in *units*."""
        return self.settings.range or self.default_range * METER[units]

    def resolution(self, units: str) -> float:
        """Return the distance a detected entity has to move before it is published again, in *units*."""
        own: float | None = self.settings.resolution
        return _RESOLUTION * METER[units] if own is None else own

    def covers(self, here: Pose, there: Point, units: str) -> bool:
        """Return whether the sensor, *here*, looks at a point, apart from obstacles between them."""
        return distance(here.point, there) <= self.range(units) and self.faces(here, there)

    def faces(self, _here: Pose, _there: Point) -> bool:
        """Return whether the sensor looks in the direction of a point: always, unless a subclass says otherwise."""
        return True
