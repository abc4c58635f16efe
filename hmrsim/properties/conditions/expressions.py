"""The robustness of conditions, as functions of signals."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Final

from hmrsim.events import EventPattern
from hmrsim.properties.model.conditions import (
    AllOf,
    AnyOf,
    BatteryCondition,
    DoorCondition,
    FaultCondition,
    ItemCondition,
    ItemsCondition,
    LaneCondition,
    Not,
    OrderCondition,
    RobotCondition,
)
from hmrsim.properties.model.part import walk
from hmrsim.properties.model.patterns import PatrollingPattern, VisitPattern
from hmrsim.properties.observing.signal import HOLDS

if TYPE_CHECKING:
    from pydantic import BaseModel

    from hmrsim.properties.observing.observations import Observations
    from hmrsim.properties.observing.signal import Signal

Value = Callable[[], float]

_JUST: Final = 1e-12
"""The distance from a bound of a value that equals it, and so is neither above nor below."""


class Expression:
    """A condition as a function of signals.

    Args:
        observations: Where the signals come from.

    Attributes:
        value: Returns the robustness now; positive if the condition holds.
        signals: What it depends on.
    """

    def __init__(self, condition: BaseModel, observations: Observations) -> None:
        self._observations = observations
        self.signals: list[Signal] = []
        self.value = self._made(condition)

    def _made(self, condition: BaseModel) -> Value:
        match condition:
            case AllOf() | AnyOf() | Not():
                return self._combined(condition)
            case EventPattern():
                return self._of(self._observations.pulse(condition))
            case RobotCondition(robot=robot, at=at, is_=state):
                return self._robot(robot, at, state)
            case ItemCondition():
                return self._item(condition)
            case ItemsCondition():
                return self._items()
        return self._thing(condition)

    def _combined(self, condition: AllOf | AnyOf | Not) -> Value:
        match condition:
            case AllOf(all=parts):
                return _least([self._made(part) for part in parts])
            case AnyOf(any=parts):
                return _greatest([self._made(part) for part in parts])
            case Not(not_=part):
                value = self._made(part)
                return lambda: -value()

    def _thing(self, condition: BaseModel) -> Value:
        seen = self._observations
        match condition:
            case BatteryCondition(battery=robot, below=below, above=above):
                share = self._of(seen.batteries.share(robot))
                return _above(share, above) if above is not None else _below(share, below or 0.0)
            case DoorCondition(door=door, is_=state):
                return self._of(seen.doors.is_(door, state))
            case OrderCondition(order=order, is_=state):
                return self._of(seen.orders.is_(order, state))
            case FaultCondition(fault=kind, robot=robot):
                return self._of(seen.faults.active(kind, robot))
            case LaneCondition(lane=lane, is_=state):
                closed = self._of(seen.lanes.closed(lane))
                return closed if state == "closed" else lambda: -closed()
        raise TypeError(condition)

    def _robot(self, robot: str, at: str | None, state: str | None) -> Value:
        seen = self._observations
        said = [self._of(seen.positions.near(robot, at))] if at is not None else []
        return _least([*said, *([self._of(seen.robots.is_(robot, state))] if state is not None else [])])

    def _item(self, condition: ItemCondition) -> Value:
        items, item = self._observations.items, condition.item
        said: list[Value] = []
        if condition.at is not None:
            # Where it lies is known without the motions of robots.
            lies = condition.carried is False
            said.append(self._of(items.lies_at(item, condition.at) if lies else items.at(item, condition.at)))
        if condition.carried is not None:
            carried = self._of(items.carried(item, None))
            said.append(carried if condition.carried else lambda: -carried())
        if condition.carried_by is not None:
            said.append(self._of(items.carried(item, condition.carried_by)))
        return _least(said)

    def _items(self) -> Value:
        """Return whether all items that this world has are where they were at the end of the run without faults."""
        seen = self._observations
        made = {spec.item or spec.name for spec in seen.world.demand}
        ends = (seen.reference or {}).items()
        there = [(name, end) for name, end in ends if name in seen.world.items or name.rpartition("_")[0] in made]
        return _least([self._of(seen.items.as_in(name, end)) for name, end in there] or [lambda: HOLDS])

    def _of(self, signal: Signal) -> Value:
        self.signals.append(signal)
        return lambda: signal.value


_FOLLOWED: Final[Mapping[type, str]] = {
    BatteryCondition: "batteries",
    DoorCondition: "doors",
    FaultCondition: "faults",
    ItemsCondition: "items",
    LaneCondition: "lanes",
    OrderCondition: "orders",
}
"""Which part of the observations a condition needs."""


def prepare(whole: BaseModel, observations: Observations) -> None:
    """Begin to follow all that a condition or a property speaks of, whose names are not known yet."""
    for _, part in walk(whole):
        match part:
            case RobotCondition(at=at, is_=state):
                _ = (at is None or observations.positions, state is None or observations.robots)
            case ItemCondition(at=at, carried=carried):
                _ = (observations.items, at is None or carried is False or observations.positions)
            case VisitPattern() | PatrollingPattern():
                _ = observations.positions
            case _ if type(part) in _FOLLOWED:
                _ = getattr(observations, _FOLLOWED[type(part)])


def _least(values: list[Value]) -> Value:
    return values[0] if len(values) == 1 else lambda: min(value() for value in values)


def _greatest(values: list[Value]) -> Value:
    return values[0] if len(values) == 1 else lambda: max(value() for value in values)


def _above(share: Value, bound: float) -> Value:
    return lambda: share() - bound or -_JUST


def _below(share: Value, bound: float) -> Value:
    return lambda: bound - share() or -_JUST
