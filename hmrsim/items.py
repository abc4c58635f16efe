"""Items that robots can pick up."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from hmrsim.geometry import Point, Pose


class Carrier(Protocol):
    """The interface of a robot that carries items."""

    @property
    def name(self) -> str:
        """The name of the carrier."""

    def pose(self) -> Pose:
        """Return where it is now."""

    def velocity(self) -> tuple[float, float]:
        """Return the speed ahead and the turning rate, now."""

    def lose(self, item: Item) -> None:
        """Hold an item no longer."""


@dataclass
class Item:
    """One item: it lies at a point, or moves with the robot that carries it.

    Attributes:
        name: Unique in its world.
        weight: In kg.
        point: Where it lies, or was picked up.
        carrier: The robot that holds it; None when it lies.
        blocks: Whether no vehicle gets past it on the lane where it lies.
        home: Where it was at the start.
    """

    name: str
    weight: float
    point: Point
    carrier: Carrier | None = None
    blocks: bool = False
    home: Point = field(init=False)

    def __post_init__(self) -> None:
        """Remember the initial position, to which a reset returns the item."""
        self.home = self.point

    @property
    def position(self) -> Point:
        """The center of the item now, which moves with its carrier."""
        return self.carrier.pose().point if self.carrier else self.point

    def attach_to(self, carrier: Carrier) -> None:
        """Move with a robot from now on."""
        self.carrier = carrier

    def lie_at(self, point: Point) -> None:
        """Lie at a point from now on."""
        self.carrier, self.point = None, point

    def detach(self) -> None:
        """Stop moving with a robot; `lie_at` sets the new position."""
        self.carrier = None
