"""The state of a run; only the parts that a consumer reads are followed."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

from hmrsim.history.facilities import Doors, Lanes
from hmrsim.history.faults import Faults
from hmrsim.history.items import Items, Orders
from hmrsim.history.robots import Batteries, Robots
from hmrsim.history.timeline import Part
from hmrsim.interfaces.simulation_interfaces import ResetSimulation

if TYPE_CHECKING:
    from hmrsim.history.timeline import Timeline
    from hmrsim.world.model import World


class History:
    """The state of a world after each occurrence of a timeline.

    A part subscribes to its events when it is first read, so read it before the run begins.
    """

    def __init__(self, timeline: Timeline, world: World) -> None:
        self._timeline, self._world = timeline, world
        timeline.on_reset(ResetSimulation.Request.SCOPE_STATE, self._begin_anew)

    @cached_property
    def robots(self) -> Robots:
        """The states of robots."""
        return Robots(self._timeline, self._world)

    @cached_property
    def batteries(self) -> Batteries:
        """The charge of batteries."""
        return Batteries(self._timeline, self._world)

    @cached_property
    def items(self) -> Items:
        """Where items are."""
        return Items(self._timeline, self._world)

    @cached_property
    def doors(self) -> Doors:
        """The states of doors."""
        return Doors(self._timeline, self._world)

    @cached_property
    def lanes(self) -> Lanes:
        """The closed lanes."""
        return Lanes(self._timeline)

    @cached_property
    def orders(self) -> Orders:
        """The progress of orders."""
        return Orders(self._timeline)

    @cached_property
    def faults(self) -> Faults:
        """The active faults."""
        return Faults(self._timeline)

    def _begin_anew(self, _at: int) -> None:
        for part in [*vars(self).values()]:
            if isinstance(part, Part):
                part.begin_anew()
