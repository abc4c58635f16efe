"""The state of the world as signals; only what is asked for is followed."""

from __future__ import annotations

from collections.abc import Collection
from functools import cached_property
from typing import TYPE_CHECKING

from hmrsim.interfaces.simulation_interfaces import ResetSimulation
from hmrsim.properties.observing.batteries import Batteries
from hmrsim.properties.observing.facilities import Doors, Lanes
from hmrsim.properties.observing.faults import Faults
from hmrsim.properties.observing.items import Items
from hmrsim.properties.observing.orders import Orders
from hmrsim.properties.observing.positions import Positions
from hmrsim.properties.observing.pulses import pulse
from hmrsim.properties.observing.robots import Robots

if TYPE_CHECKING:
    from hmrsim.events import EventPattern
    from hmrsim.history.timeline import Timeline
    from hmrsim.properties.observing.signal import Signal
    from hmrsim.properties.results import Reference
    from hmrsim.world.model import World


class Observations:
    """Follows a run, as far as signals are asked for.

    Attributes:
        timeline: The time of the run.
        world: The world that is run.
        reference: The items at the end of the run without faults; None if there is none to compare with.
    """

    def __init__(self, world: World, timeline: Timeline, reference: Reference | None = None) -> None:
        self.world, self.timeline, self.reference = world, timeline, reference
        self._pulses: list[tuple[EventPattern, Signal]] = []
        timeline.on_reset(ResetSimulation.Request.SCOPE_STATE, self._begin_anew)

    @cached_property
    def robots(self) -> Robots:
        """What robots do."""
        return Robots(self.world, self.timeline)

    @cached_property
    def positions(self) -> Positions:
        """Where robots are."""
        return Positions(self.world, self.timeline)

    @cached_property
    def items(self) -> Items:
        """Where items are."""
        return Items(self.world, self.timeline, lambda: self.positions)

    @cached_property
    def batteries(self) -> Batteries:
        """How full batteries are."""
        return Batteries(self.world, self.timeline)

    @cached_property
    def doors(self) -> Doors:
        """Which doors are open."""
        return Doors(self.world, self.timeline)

    @cached_property
    def lanes(self) -> Lanes:
        """Which lanes are closed."""
        return Lanes(self.timeline)

    @cached_property
    def orders(self) -> Orders:
        """How far orders are."""
        return Orders(self.timeline)

    @cached_property
    def faults(self) -> Faults:
        """Which faults are active."""
        return Faults(self.timeline)

    @property
    def powered(self) -> Collection[str]:
        """The robots whose batteries are asked for, also from now on."""
        return self.batteries.shares.keys() if "batteries" in self.__dict__ else ()

    def pulse(self, pattern: EventPattern) -> Signal:
        """Return a signal that holds at the instants of some events."""
        known = next((signal for each, signal in self._pulses if each == pattern), None)
        if known is None:
            known = pulse(self.timeline, pattern)
            self._pulses.append((pattern, known))
        return known

    def _begin_anew(self, _at: int) -> None:
        for name in _PARTS:
            part = self.__dict__.get(name)
            if part is not None:
                part.begin_anew()


_PARTS = ("robots", "positions", "items", "batteries", "doors", "lanes", "orders", "faults")
