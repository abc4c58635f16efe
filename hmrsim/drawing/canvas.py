"""The canvas that all parts of a picture share: the world, the positions of its points, and its style."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Final

from hmrsim.drawing.palette import type_looks

if TYPE_CHECKING:
    from hmrsim.drawing.frame import Frame
    from hmrsim.world.model import World

_MAX_MARK: Final = 7.0
_MIN_MARK: Final = 1.2


class Canvas:
    """A world, and how it is drawn.

    Attributes:
        width: Of the picture, in pixels.
        details: Whether speed limits and capacities are written beside lanes.
        mark: The size of a mark, in pixels.
    """

    def __init__(self, world: World, colours: Mapping[str, str], frame: Frame, *, width: float, details: bool) -> None:
        self.world = world
        self.colours = colours
        self.types = type_looks(world)
        self.frame = frame
        self.width = width
        self.details = details
        self.mark = self._mark_size()

    def _mark_size(self) -> float:
        """Return the size of a mark, in pixels: where there is much, marks are small."""
        world, (width, height) = self.world, self.frame.size
        count = sum(len(things) for things in (world.waypoints, world.places, world.docks, world.items, world.robots))
        return min(_MAX_MARK, max(_MIN_MARK, math.sqrt(width * height / max(1, count)) / 8))

    def robot_radius(self, name: str) -> float:
        """Return how large a robot is drawn: as large as it is, but not too small to be seen."""
        radius = self.world.robot_type(self.world.robots[name]).base.radius or 0.0
        # A body does not fill its circle.
        return max(1.2 * self.mark, radius * self.frame.scale)
