"""Conditions of a file as functions of the state of the world."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import partial
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
from hmrsim.properties.model.property import PatrollingPattern, VisitPattern
from hmrsim.properties.robustness import JUST
from hmrsim.properties.signals import FAILS, HOLDS, watch

if TYPE_CHECKING:
    from pydantic import BaseModel

    from hmrsim.events import Event
    from hmrsim.history.timeline import GoalSeen
    from hmrsim.properties.model.conditions import Condition
    from hmrsim.properties.observations import Observations
    from hmrsim.properties.signals import Signal

Value = Callable[[], float]


class Expression:
    """A condition as a function of signals.

    Attributes:
        value: Returns the robustness now; positive if the condition holds.
        signals: The signals that it depends on.
    """

    def __init__(self, condition: Condition, observations: Observations) -> None:
        self._observations = observations
        self.signals: list[Signal] = []
        self.value = self._value(condition)

    def _value(self, condition: Condition) -> Value:
        match condition:
            case AllOf(all=parts) | AnyOf(any=parts):
                values = [self._value(part) for part in parts]
                return _combined(min if isinstance(condition, AllOf) else max, values)
            case Not(not_=part):
                return _opposite(self._value(part))
            case LaneCondition(lane=lane, is_=state):
                lanes = self._observations.history.lanes
                closed = self._of(self._observations.whether(lanes, lane, "closed", partial(lanes.is_closed, lane)))
                return closed if state == "closed" else _opposite(closed)
            case BatteryCondition(battery=robot, below=below, above=above):
                share = self._of(self._observations.battery_share(robot))
                return _above(share, above) if above is not None else lambda: (below or 0.0) - share() or -JUST
            case ItemCondition():
                return self._item(condition)
        return _combined(min, [self._of(signal) for signal in self._signals(condition)])

    def _signals(self, condition: Condition) -> list[Signal]:
        """Return the signals that all have to hold."""
        seen, history = self._observations, self._observations.history
        match condition:
            case EventPattern():
                return [seen.pulse(condition)]
            case RobotCondition(robot=robot, at=at, is_=state):
                near = [seen.positions.near(robot, at)] if at is not None else []
                return [*near, *([seen.is_(history.robots, robot, state)] if state is not None else [])]
            case DoorCondition(door=door, is_=state):
                return [seen.is_(history.doors, door, state)]
            case OrderCondition(order=order, is_=state):
                return [seen.is_(history.orders, order, state)]
            case FaultCondition(fault=kind, robot=robot):
                faults = history.faults
                return [seen.whether(faults, kind, robot, partial(faults.is_active, kind, robot))]
            case ItemsCondition():
                # A smaller world, and its orders, may lack items of the run without faults.
                made = {spec.item or spec.name for spec in seen.world.demand}
                ends = (seen.reference or {}).items()
                return [
                    seen.item_is_as_in(name, end)
                    for name, end in ends
                    if name in seen.world.items or name.rpartition("_")[0] in made
                ]
        raise TypeError(condition)

    def _item(self, condition: ItemCondition) -> Value:
        seen, item = self._observations, condition.item
        values: list[Value] = []
        if condition.at is not None:
            # An item that lies somewhere can be followed without the motions of robots.
            lies = condition.carried is False
            values.append(
                self._of(seen.item_lies_at(item, condition.at) if lies else seen.item_is_at(item, condition.at))
            )
        if condition.carried is not None:
            carried = self._of(seen.item_is_carried(item, None))
            values.append(carried if condition.carried else _opposite(carried))
        if condition.carried_by is not None:
            values.append(self._of(seen.item_is_carried(item, condition.carried_by)))
        return _combined(min, values)

    def _of(self, signal: Signal) -> Value:
        self.signals.append(signal)
        return lambda: signal.value


class Term:
    """A condition of a property, which is evaluated at the end of each instant at which it may have changed.

    An event holds at its instant, and each event counts; any other condition counts when it begins to hold.

    Args:
        changed: Called when the condition may have changed.
        template: The condition as the file has it, with ``*`` and ``$field``; the condition itself if left out.

    Attributes:
        value: The robustness at the last look.
        hits: How often it has begun to hold since the look before.
        times: How often it has begun to hold.
        words: The condition in words that do not depend on robots.
    """

    def __init__(
        self,
        condition: Condition,
        observations: Observations,
        changed: Callable[[], object],
        template: Condition | None = None,
    ) -> None:
        self.value = FAILS
        self.hits = self.times = 0
        self.text = condition.describe()
        self.words = self.text if template is None else template.describe()
        self._came = 0
        self._changed = changed
        self._expression: Expression | None = None
        if isinstance(condition, EventPattern):
            watch(observations.timeline, condition, self._come)
        else:
            self._expression = Expression(condition, observations)
            for signal in self._expression.signals:
                signal.subscribe(changed)

    @property
    def holds(self) -> bool:
        """True if the condition held when it was last evaluated."""
        return self.value > 0.0

    def look(self) -> None:
        """Evaluate the condition again and update its value."""
        if self._expression is None:
            self.hits, self._came = self._came, 0
            self.value = HOLDS if self.hits else FAILS
        else:
            held, self.value = self.value > 0.0, self._expression.value()
            self.hits = int(self.value > 0.0 and not held)
        self.times += self.hits

    def close(self) -> None:
        """Stop observing it."""
        for signal in self._expression.signals if self._expression else ():
            signal.unsubscribe(self._changed)

    def _come(self, _at: int, _event: Event | GoalSeen) -> None:
        self._came += 1
        self._changed()


_OBSERVED: Final[Mapping[type, str]] = {
    BatteryCondition: "batteries",
    DoorCondition: "doors",
    FaultCondition: "faults",
    ItemsCondition: "items",
    LaneCondition: "lanes",
    OrderCondition: "orders",
}
"""The part of the history that a condition needs."""


def prepare(whole: BaseModel, observations: Observations) -> None:
    """Begin to observe all that a condition or a property needs once its names are known."""
    history = observations.history
    for _, part in walk(whole):
        match part:
            case RobotCondition(at=at, is_=state):
                _ = (at is None or observations.positions, state is None or history.robots)
            case ItemCondition(at=at, carried=carried):
                _ = (history.items, at is None or carried is False or observations.positions)
            case VisitPattern() | PatrollingPattern():
                _ = observations.positions
            case _ if type(part) in _OBSERVED:
                _ = getattr(history, _OBSERVED[type(part)])


def _combined(of: Callable[[Iterable[float]], float], values: list[Value]) -> Value:
    if not values:
        return lambda: HOLDS
    return values[0] if len(values) == 1 else lambda: of(value() for value in values)


def _above(share: Value, bound: float) -> Value:
    return lambda: share() - bound or -JUST


def _opposite(value: Value) -> Value:
    return lambda: -value()
