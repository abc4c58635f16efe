"""The state of the world as signals; only the requested ones are updated."""

from __future__ import annotations

from collections.abc import Callable, Collection, Hashable
from functools import cached_property, partial
from typing import TYPE_CHECKING

from hmrsim.geometry import distance
from hmrsim.history.history import History
from hmrsim.properties.positions import Positions, point_of
from hmrsim.properties.signals import FAILS, HOLDS, Signal, pulse
from hmrsim.simulation.demand import NEAR

if TYPE_CHECKING:
    from hmrsim.events import EventPattern
    from hmrsim.geometry import Point
    from hmrsim.history.timeline import Part, Timeline
    from hmrsim.properties.results import ItemEnd, Reference
    from hmrsim.world.model import World


class Observations:
    """The signals of a run.

    Attributes:
        timeline: The time of the run.
        world: The world of the run.
        history: The state of the world.
        reference: The items at the end of the run without faults; None if there is none to compare with.
    """

    def __init__(self, world: World, timeline: Timeline, reference: Reference | None = None) -> None:
        self.world, self.timeline, self.reference = world, timeline, reference
        self.history = History(timeline, world)
        self._radius = NEAR[world.units]
        self._signals: dict[Hashable, Signal] = {}
        self._pulses: list[tuple[EventPattern, Signal]] = []

    @cached_property
    def positions(self) -> Positions:
        """Where robots are."""
        return Positions(self.world, self.timeline)

    @property
    def powered(self) -> Collection[str]:
        """The robots whose batteries are followed; it includes those that are requested later."""
        return self.history.batteries.shares.keys() if "batteries" in vars(self.history) else ()

    def robot_is(self, robot: str, state: str) -> Signal:
        """Return whether a robot is in a state."""
        robots = self.history.robots
        return self._whether(robots, robot, state, partial(robots.is_, robot, state))

    def door_is(self, door: str, state: str) -> Signal:
        """Return whether a door is in a state; a jammed door is also open or closed."""
        doors = self.history.doors
        return self._whether(doors, door, state, partial(doors.is_, door, state))

    def lane_is_closed(self, lane: tuple[str, str]) -> Signal:
        """Return whether a lane is closed."""
        lanes = self.history.lanes
        return self._whether(lanes, lane, "closed", partial(lanes.is_closed, lane))

    def order_is(self, order: str, state: str) -> Signal:
        """Return whether an order is in a state; a late order is also in another one."""
        orders = self.history.orders
        return self._whether(orders, order, state, partial(orders.is_, order, state))

    def fault_is_active(self, kind: str, robot: str | None) -> Signal:
        """Return whether a fault of a kind is active, of a robot or of any."""
        faults = self.history.faults
        return self._whether(faults, kind, robot, partial(faults.is_active, kind, robot))

    def battery_share(self, robot: str) -> Signal:
        """Return the remaining share of a robot's battery; 1 without a battery."""
        batteries = self.history.batteries
        batteries.follow(robot)
        return self._value(batteries, robot, "share", partial(batteries.shares.__getitem__, robot))

    def item_lies_at(self, item: str, place: str) -> Signal:
        """Return whether an item lies at a place, and no robot carries it."""
        where = point_of(self.world, place)
        return self._whether(
            self.history.items, item, f"lies at {place}", lambda: where is not None and self._lies_near(item, where)
        )

    def item_is_as_in(self, item: str, end: ItemEnd) -> Signal:
        """Return whether an item is where it was at the end of another run: it lies near that point, or is carried."""
        items = self.history.items
        return self._whether(
            items,
            item,
            end,
            lambda: bool(items[item].carrier) if end.carried else self._lies_near(item, end.at),
        )

    def item_is_carried(self, item: str, by: str | None) -> Signal:
        """Return whether an item is carried, by a robot or by any."""
        items = self.history.items
        return self._whether(
            items, item, f"carried by {by}", lambda: bool(items[item].carrier) and by in (None, items[item].carrier)
        )

    def item_is_at(self, item: str, place: str) -> Signal:
        """Return whether an item is at a place, where it lies or is carried."""
        items, lies, carriers = self.history.items, self.item_lies_at(item, place), dict[str, Signal]()

        def follow(robot: str) -> None:
            carriers[robot] = self.positions.near(robot, place)
            carriers[robot].tell(lambda: found.set(value()))

        def value() -> float:
            carrier = items[item].carrier
            if not carrier:
                return lies.value
            if carrier not in carriers:
                follow(carrier)
            return carriers[carrier].value

        found = self._value(items, item, f"at {place}", value)
        # Where a robot is when it picks up the item follows from its motion until then.
        for name, robot in self.world.robots.items():
            if name not in carriers and "claw" in self.world.robot_type(robot).components:
                follow(name)
        return found

    def pulse(self, pattern: EventPattern) -> Signal:
        """Return a signal that holds at the instants of some events."""
        known = next((signal for each, signal in self._pulses if each == pattern), None)
        if known is None:
            known = pulse(self.timeline, pattern)
            self._pulses.append((pattern, known))
        return known

    def _lies_near(self, item: str, where: Point) -> bool:
        known = self.history.items[item]
        return not known.carrier and known.at is not None and distance(known.at, where) <= self._radius

    def _whether(self, part: Part, name: Hashable, what: Hashable, holds: Callable[[], bool]) -> Signal:
        """Return the signal of whether something holds for a member of a part."""
        key = part, name, what
        signal = self._signals.get(key)
        if signal is None:
            signal = self._signals[key] = Signal(HOLDS if holds() else FAILS)
            part.watch(name, lambda: signal.set(HOLDS if holds() else FAILS))
        return signal

    def _value(self, part: Part, name: Hashable, what: Hashable, value: Callable[[], float]) -> Signal:
        """Return the signal of a value of a member of a part."""
        key = part, name, what
        signal = self._signals.get(key)
        if signal is None:
            signal = self._signals[key] = Signal(value())
            part.watch(name, lambda: signal.set(value()))
        return signal
