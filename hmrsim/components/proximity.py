"""A proximity sensor: notices the robots and items around it."""

from __future__ import annotations

from dataclasses import dataclass

from hmrsim.components import Component, Sensor, SensorSettings


class ProximitySettings(SensorSettings):
    """The range of a proximity sensor.

    Attributes:
        range: Range, from the robot's center to that of the detected entity; None for 2 m, or 160 px.
        resolution: Distance a detected entity has to move before it is published again; None for 0.1 m, or 8 px.
        through_walls: Whether the sensor detects entities behind walls, as with radio tags.
    """

    through_walls: bool = False


@dataclass(eq=False)
class Proximity(Sensor):
    """A proximity sensor that a robot carries."""

    default_range = 2.0

    @property
    def through_walls(self) -> bool:
        """Return whether the sensor detects items through walls."""
        through: bool = self.settings.through_walls
        return through


COMPONENT = Component(name="proximity", settings=ProximitySettings, create=Proximity)
