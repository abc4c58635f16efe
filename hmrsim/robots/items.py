"""Things that can be picked up, and where they are."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hmrsim.geometry import Point
    from hmrsim.robots.robot import Robot


@dataclass
class Item:
    """One item: it lies at a point, or moves with the robot that carries it.

    Attributes:
        name: Unique in its world.
        weight: In kg.
        point: Where it lies, or was picked up.
        carrier: Who holds it; None when it lies.
        blocks: Whether nobody gets past it on the lane where it lies.
        home: Where it was in the beginning.
    """

    name: str
    weight: float
    point: Point
    carrier: Robot | None = None
    blocks: bool = False
    home: Point = field(init=False)

    def __post_init__(self) -> None:
        """Remember where it is."""
        self.home = self.point

    @property
    def position(self) -> Point:
        """Where its centre is now."""
        return self.carrier.pose().point if self.carrier else self.point
