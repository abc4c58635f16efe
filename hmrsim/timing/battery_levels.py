"""The conditions on the level of one robot's battery, and when the next of them may be met.

The level is a formula of time between two changes of the load, so that the instant at which a value is reached can be
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
"""A participant, and what it calls a condition."""

_SHARE: Final = ("percentage",)
_LEVELS: Final = (_SHARE, ("charge",))
"""The fields of a battery's state whose values are computed for any time."""

_FALLING: Final = ("<", "<=")


class _Kind(NamedTuple):
    """Comparisons of one field with one operator: a level that falls or rises reaches the nearest value first."""

    path: tuple[str, ...]
    operator: str

    def holds(self, level: float, value: float) -> bool:
        return ORDERS[self.operator](level, value)


class _Waiting(NamedTuple):
    """A condition that waits for one of its comparisons; the nearest value sorts last."""

    order: float
    condition: ConditionId
    value: float


class BatteryLevels:
    """The conditions on the level of one robot's battery.

    Each waits for one of its comparisons that does not hold now: until that one does, the condition can't be met. So
    whatever happens to the battery, only the nearest value of each field and operator is looked at.

    Args:
        energy: The account of the battery, which is observed from now on.
        changed: Called when another load begins, or the charge has jumped.
    """

    def __init__(self, energy: Energy, changed: Callable[[], None]) -> None:
        self.energy = energy
        self._changed = changed
        self._watches: dict[ConditionId, Watch] = {}
        self._waiting: dict[_Kind, list[_Waiting]] = {}
        self._places: dict[ConditionId, tuple[_Kind, _Waiting]] = {}
        # Those of which all comparisons of levels hold, and others may not.
        self._open: dict[ConditionId, None] = {}
        energy.observe(changed)

    def close(self) -> None:
        """Observe the battery no longer."""
        self.energy.ignore(self._changed)

    def add(self, condition: ConditionId, watch: Watch, now: float) -> float:
        """Add a condition; return when it is to be looked at, infinite if others come before it or it is never met."""
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
        """Return the conditions that may be met now; each is to be removed then, or added again."""
        taken = [*self._open]
        for kind, waiting in self._waiting.items():
            level = _level(self.energy, kind.path, now)
            while waiting and kind.holds(level, waiting[-1].value):
                taken.append(waiting.pop().condition)
                del self._places[taken[-1]]
        self._open.clear()
        return [(condition, self._watches[condition]) for condition in taken]

    def due(self, now: float, *, looked: bool) -> float:
        """Return when a condition is to be looked at next; infinite if none is as things are.

        Args:
            now: The present time, which is the answer if one may be met now.
            looked: Whether those that may be met now were looked at.
        """
        if self._open and not looked:
            return now
        return min((self._reached(kind, now) for kind, waiting in self._waiting.items() if waiting), default=math.inf)

    def _reached(self, kind: _Kind, now: float) -> float:
        """Return when the nearest value of a kind is reached: now, or after whole nanoseconds."""
        value = self._waiting[kind][-1].value
        if kind.holds(_level(self.energy, kind.path, now), value):
            return now
        return _reached(self.energy, kind, value, now)


def is_level(comparison: Comparison) -> bool:
    """Return whether it can be computed when a comparison of a battery's state holds."""
    return comparison.path in _LEVELS and comparison.operator in ORDERS


def _number(value: object) -> float | None:
    """Return what a level is compared with; None for what it has no order with."""
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
    """Return from when on a comparison holds that does not hold now; infinite if it never does as things are."""
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
    """Return the first whole number above *low* at which a condition holds, which is about *high*, if there is one."""
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
