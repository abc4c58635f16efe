"""The conditions on the level of one robot's battery, and the time at which the next of them may be met.

Between two changes of the load the level is a formula of time, so that the instant at which it reaches a value can be
computed.
"""

from __future__ import annotations

import math
from bisect import bisect_left, insort
from collections.abc import Callable
from typing import TYPE_CHECKING, Final, NamedTuple

from hmrsim.engine.sim_time import stamp
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.protocol.topics import ORDERS

if TYPE_CHECKING:
    from hmrsim.protocol.topics import Comparison, Watch
    from hmrsim.robots.power import Energy

ConditionId = tuple[str, str]
"""A participant, and its name for a condition."""

_SHARE: Final = ("percentage",)
_LEVELS: Final = (_SHARE, ("charge",))
"""The fields of a battery's state whose values are computed for any time."""

_FALLING: Final = ("<", "<=")


class _Kind(NamedTuple):
    """The comparisons of one field with one operator, of which the one with the nearest value holds first."""

    path: tuple[str, ...]
    operator: str

    def holds(self, level: float, value: float) -> bool:
        return ORDERS[self.operator](level, value)


class _Waiting(NamedTuple):
    """A condition that waits for one of its comparisons to hold; the nearest value sorts last."""

    order: float
    condition: ConditionId
    value: float


class BatteryLevels:
    """The conditions on the level of one robot's battery.

    Each condition waits for one of its comparisons that does not hold now; until that one holds, the condition can't be
    met. So only the nearest value of each field and operator has to be checked.

    Args:
        energy: The account of the battery, which is observed from now on.
        changed: Called when the load changes or the charge jumps.
    """

    def __init__(self, energy: Energy, changed: Callable[[], None]) -> None:
        self.energy = energy
        self._changed = changed
        self._watches: dict[ConditionId, Watch] = {}
        self._waiting: dict[_Kind, list[_Waiting]] = {}
        self._places: dict[ConditionId, tuple[_Kind, _Waiting]] = {}
        # The conditions of which all comparisons of levels hold; their other comparisons may not hold.
        self._open: dict[ConditionId, None] = {}
        energy.observe(changed)

    def close(self) -> None:
        """Stop observing the battery."""
        self.energy.ignore(self._changed)

    def add(self, condition: ConditionId, watch: Watch, now: float) -> float:
        """Add a condition; return when to check it, infinite if others come before it or it is never met."""
        self._watches[condition] = watch
        never = False
        for path, operator, value in filter(is_level, watch.comparisons):
            kind, number = _Kind(path, operator), _number(value)
            if number is None:
                never = True
            elif not kind.holds(_level(self.energy, path, now), number):
                entry = _Waiting(number if operator in _FALLING else -number, condition, number)
                insort(self._waiting.setdefault(kind, []), entry)
                self._places[condition] = kind, entry
                return self._reached(kind, now) if self._waiting[kind][-1] is entry else math.inf
        if never:
            return math.inf
        self._open[condition] = None
        return now

    def remove(self, condition: ConditionId) -> None:
        """Remove a condition."""
        del self._watches[condition]
        self._open.pop(condition, None)
        if place := self._places.pop(condition, None):
            kind, entry = place
            waiting = self._waiting[kind]
            del waiting[bisect_left(waiting, entry)]

    def take(self, now: float) -> list[tuple[ConditionId, Watch]]:
        """Return the conditions that may be met now; the caller removes each of them, or adds it again."""
        taken = [*self._open]
        for kind, waiting in self._waiting.items():
            level = _level(self.energy, kind.path, now)
            while waiting and kind.holds(level, waiting[-1].value):
                taken.append(waiting.pop().condition)
                del self._places[taken[-1]]
        self._open.clear()
        return [(condition, self._watches[condition]) for condition in taken]

    def due(self, now: float, *, looked: bool) -> float:
        """Return when to check a condition next; infinite if none will be met under the present load.

        Args:
            now: The present time, which is returned if a condition may be met now.
            looked: Whether those that may be met now were checked already.
        """
        if self._open and not looked:
            return now
        return min((self._reached(kind, now) for kind, waiting in self._waiting.items() if waiting), default=math.inf)

    def _reached(self, kind: _Kind, now: float) -> float:
        """Return when the level reaches the nearest value of a kind: now, or after whole nanoseconds."""
        value = self._waiting[kind][-1].value
        if kind.holds(_level(self.energy, kind.path, now), value):
            return now
        return _reached(self.energy, kind, value, now)


def is_level(comparison: Comparison) -> bool:
    """Return whether it can be computed when a comparison of a battery's state holds."""
    return comparison.path in _LEVELS and comparison.operator in ORDERS


def _number(value: object) -> float | None:
    """Return the number that a level is compared with; None for a value that can't be compared with a number."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return None
    try:
        number = float(value)
    except OverflowError:
        return math.inf if value > 0 else -math.inf
    return None if math.isnan(number) else number


def _level(energy: Energy, path: tuple[str, ...], seconds: float) -> float:
    battery = energy.battery
    return battery.share(seconds) if path == _SHARE else battery.ampere_hours(battery.charge(seconds))


def _reached(energy: Energy, kind: _Kind, value: float, now: float) -> float:
    """Return when a comparison that does not hold now begins to hold; infinite if it never does under this load."""
    battery = energy.battery
    flow, charge = battery.flow(now), battery.charge(now)
    level = value * battery.usable if kind.path == _SHARE else battery.energy(value)
    ahead = 0.0 <= level <= charge if flow < 0.0 else flow > 0.0 and charge <= level <= battery.usable
    reached = battery.reaches(level) if ahead else math.inf
    if reached == math.inf:
        return math.inf
    # The first instant is two nanoseconds long: within it time does not advance.
    instant = stamp(now)
    high = max(math.ceil(reached * NANOSECONDS), instant + 1)
    return (
        _first(lambda at: kind.holds(_level(energy, kind.path, at / NANOSECONDS), value), instant, high) / NANOSECONDS
    )


def _first(holds: Callable[[int], bool], low: int, high: int) -> float:
    """Return the first whole number above *low* at which a condition holds, which is about *high*; else infinity."""
    step = 1
    while not holds(high):
        low, high, step = high, high + step, step * 2
        if step > NANOSECONDS:
            return math.inf
    low = max(low, high - 8) if not holds(max(low, high - 8)) else low
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if holds(middle) else (middle, high)
    return high
