"""A claw: picks up and holds one item."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated

from pydantic import Field

from hmrsim.components import Component, Settings
from hmrsim.distributions import RandomSeconds
from hmrsim.geometry import METER

if TYPE_CHECKING:
    from hmrsim.items import Item


class ClawSettings(Settings):
    """The reach and payload of a claw.

    Attributes:
        reach: Maximum distance of an item from the robot's center; None for 1 m, or 80 px.
        max_weight: Maximum weight of an item, in kg; None for no limit.
        handling_time: Seconds to pick up or to place an item.
    """

    reach: Annotated[float, Field(strict=True, gt=0, le=1e9)] | None = None
    max_weight: Annotated[float, Field(strict=True, gt=0, le=1e9)] | None = None
    handling_time: RandomSeconds = 0.0


@dataclass
class Claw:
    """A claw that a robot carries.

    Attributes:
        misses: The causes that make it miss; each returns whether it does, this time.
    """

    settings: ClawSettings
    item: Item | None = None
    misses: list[Callable[[], bool]] = field(default_factory=list)

    def reach(self, units: str) -> float:
        """Return how far it reaches, in *units*."""
        return self.settings.reach or METER[units]

    def grasp(self, item: Item) -> None:
        """Grasp an item, and hold it."""
        self.item = item

    def release(self) -> None:
        """Release the held item, if any."""
        self.item = None


COMPONENT = Component(name="claw", settings=ClawSettings, create=Claw)
