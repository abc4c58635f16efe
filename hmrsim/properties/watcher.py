"""Watchers: each follows one property of a run, and gives the verdict on it."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Generic, TypeVar

from hmrsim.events.simulation import Spawned
from hmrsim.history.timeline import Phase
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.properties.results import Verdict, Violation

if TYPE_CHECKING:
    from hmrsim.history.timeline import Alarm, Timeline
    from hmrsim.properties.results import Ended, OnViolation, State
    from hmrsim.properties.terms import Term


class Watcher:
    """Watches one property; a subclass subscribes to occurrences of a timeline.

    Attributes:
        first: The first violation; None if there is none.
    """

    def __init__(self, name: str, on_violation: OnViolation) -> None:
        self.name = name
        self.first: Violation | None = None
        self.count = 0
        self._on_violation = on_violation

    def violate(self, at: int, subject: str, reason: str, text: str, *, fatal: bool = False) -> None:
        """Count a violation and report it."""
        violation = Violation(self.name, subject, at, reason, text, fatal)
        self.count += 1
        self.first = self.first or violation
        self._on_violation(violation)

    def begin(self, at: int) -> None:
        """Process the beginning of the run."""

    def end(self, at: int, ended: Ended | None) -> None:
        """Process the end of the run; *ended* is None if its ending is unknown."""

    def verdict(self) -> Verdict:
        """Return the verdict on the property."""
        if self.first is None:
            return self._unless_violated()
        more = f", and {self.count - 1} more" if self.count > 1 else ""
        return Verdict(self.name, "violated", -1.0, f"{self.first.text}{more}")

    def _unless_violated(self) -> Verdict:
        """Return the verdict on a property that is not violated."""
        raise NotImplementedError

    def _is(self, state: State, robustness: float, text: str) -> Verdict:
        return Verdict(self.name, state, max(-1.0, min(1.0, robustness)), text)


def cut_off(ended: Ended | None) -> bool:
    """Return whether the run was ended from outside, so that missing events might still have come."""
    return ended is not None and ended.ending == "stopped"


K = TypeVar("K", bound=Hashable)


@dataclass(slots=True, eq=False)
class Obligation(Generic[K]):
    """A demand that is still to be met.

    Attributes:
        since: The time from which it is open.
        key: The key under which it is met.
        subject: The robot or order that it concerns.
        text: The demand in words.
        term: The condition that meets it, if each obligation has its own.
        alarm: Rings when it is too late; None if it never is.
    """

    since: int
    key: K
    subject: str = ""
    text: str = ""
    term: Term | None = None
    alarm: Alarm | None = None


class Obligations(Generic[K]):
    """The open obligations of a property, by keys.

    Args:
        within: Seconds within which each has to be met; None for any time.
        expired: Called with the time and each obligation that is not met in time.
        keep: Whether an obligation that has expired stays open until it is met.

    Attributes:
        longest: The longest time that one was open until it was met, in nanoseconds.
    """

    def __init__(
        self,
        timeline: Timeline,
        within: float | None,
        expired: Callable[[int, Obligation[K]], object],
        *,
        keep: bool = False,
    ) -> None:
        self._timeline = timeline
        self._within = within
        self._expired = expired
        self._keep = keep
        self._open: dict[K, list[Obligation[K]]] = {}
        self.count = 0
        self.longest = 0

    def __contains__(self, key: K) -> bool:
        """Return whether an obligation with a key is open."""
        return key in self._open

    def __iter__(self) -> Iterator[K]:
        """Yield the keys of open obligations, which may be met during the iteration."""
        return iter([*self._open])

    def __bool__(self) -> bool:
        """Return whether any is open."""
        return bool(self._open)

    @property
    def open(self) -> list[Obligation[K]]:
        """The open obligations, in order of time."""
        return sorted((each for same in self._open.values() for each in same), key=lambda each: each.since)

    @property
    def least(self) -> float:
        """The least share of its time that was left when an obligation was met."""
        return 1.0 - self.seconds / self._within if self._within else 1.0

    @property
    def seconds(self) -> float:
        """The longest time that an obligation was open until it was met."""
        return self.longest / NANOSECONDS

    def add(self, obligation: Obligation[K]) -> None:
        """Open an obligation."""
        self.count += 1
        self._open.setdefault(obligation.key, []).append(obligation)
        if self._within is not None:
            due = obligation.since + round(self._within * NANOSECONDS)
            obligation.alarm = self._timeline.alarm(due, Phase.EXPIRY, lambda at: self._expire(at, obligation))

    def meet(self, at: int, key: K) -> None:
        """Close all obligations with a key."""
        for obligation in self._open.pop(key, ()):
            self._close(at, obligation)

    def meet_terms(self, at: int) -> None:
        """Close the obligations whose term holds now."""
        for obligation in [each for same in self._open.values() for each in same]:
            if obligation.term is not None:
                obligation.term.look()
                if obligation.term.holds:
                    self._close(at, obligation)
                    self._remove(obligation)

    def end(self, at: int) -> None:
        """Count the time that obligations have been open by the end of the run."""
        self.longest = max([self.longest, *(at - each.since for each in self.open)])

    def _close(self, at: int, obligation: Obligation[K]) -> None:
        if obligation.alarm is not None:
            obligation.alarm.cancel()
        if obligation.term is not None:
            obligation.term.close()
        self.longest = max(self.longest, at - obligation.since)

    def _expire(self, at: int, obligation: Obligation[K]) -> None:
        if obligation.term is not None:
            obligation.term.close()
        if not self._keep:
            self._remove(obligation)
        self._expired(at, obligation)

    def _remove(self, obligation: Obligation[K]) -> None:
        same = self._open[obligation.key]
        same.remove(obligation)
        if not same:
            del self._open[obligation.key]


_WORST_FIRST: Final[tuple[State, ...]] = ("violated", "undecided", "holds", "never_exercised")


class Each(Watcher):
    """Watches a property for each robot separately, including robots that are spawned later.

    Args:
        all_count: Whether the property is exercised only if it is for each robot.
    """

    def __init__(
        self,
        name: str,
        robots: Iterable[str],
        make: Callable[[str], Watcher],
        timeline: Timeline,
        on_violation: OnViolation,
        *,
        all_count: bool = False,
    ) -> None:
        super().__init__(name, on_violation)
        self._make = make
        self._order = ("violated", "undecided", "never_exercised", "holds") if all_count else _WORST_FIRST
        self._watchers = {robot: make(robot) for robot in robots}
        timeline.on(Spawned, self._spawn)

    def _spawn(self, at: int, event: Spawned) -> None:
        if event.type != "item" and event.entity not in self._watchers:
            self._watchers[event.entity] = self._make(event.entity)
            self._watchers[event.entity].begin(at)

    def begin(self, at: int) -> None:
        """Begin the watcher of each robot."""
        for watcher in self._watchers.values():
            watcher.begin(at)

    def end(self, at: int, ended: Ended | None) -> None:
        """End the watcher of each robot."""
        for watcher in self._watchers.values():
            watcher.end(at, ended)

    def verdict(self) -> Verdict:
        """Return the worst verdict of all robots."""
        verdicts = [(robot, watcher.verdict()) for robot, watcher in self._watchers.items()]
        if not verdicts:
            return self._is("never_exercised", 1.0, "there is no robot that it is about")
        robot, worst = min(verdicts, key=lambda each: (self._order.index(each[1].state), each[1].robustness))
        same = sum(verdict.state == worst.state for _, verdict in verdicts)
        more = f" (and {same - 1} more robots)" if same > 1 else ""
        robustness = min(verdict.robustness for _, verdict in verdicts)
        return Verdict(self.name, worst.state, robustness, f"{robot}: {worst.text}{more}")


class Incomparable(Watcher):
    """A property that compares with the run without faults, in a run for which there is no such comparison."""

    def _unless_violated(self) -> Verdict:
        return self._is("undecided", 0.0, "there is no run without faults to compare with")
