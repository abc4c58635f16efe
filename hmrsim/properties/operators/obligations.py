"""Obligations: what has to follow each trigger, and by when."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.properties.observing.timeline import Phase

if TYPE_CHECKING:
    from hmrsim.properties.conditions.terms import Term
    from hmrsim.properties.observing.timeline import Alarm, Timeline


@dataclass(slots=True, eq=False)
class Obligation:
    """Something has to follow.

    Attributes:
        since: When it was triggered.
        subject: Whom it concerns.
        said: What has to follow, in words.
        term: What has to hold, if that is looked at for this obligation alone.
        alarm: Rings when it is too late; None if it never is.
    """

    since: int
    subject: str
    said: str
    term: Term | None = None
    alarm: Alarm | None = None


class Obligations:
    """The obligations of a property that are open, by what they are about.

    Args:
        within: Seconds; None for any time.
        expired: Called with the time and each obligation that was not met in time.

    Attributes:
        count: How many there were.
        least: The least share of its time that was left when one was met.
    """

    def __init__(self, timeline: Timeline, within: float | None, expired: Callable[[int, Obligation], object]) -> None:
        self._timeline = timeline
        self._within = within
        self._expired = expired
        self._open: dict[Hashable, list[Obligation]] = {}
        self.count = 0
        self.least = 1.0

    def __bool__(self) -> bool:
        """Return whether any is open."""
        return bool(self._open)

    def add(self, key: Hashable, obligation: Obligation) -> None:
        """Open an obligation."""
        self.count += 1
        self._open.setdefault(key, []).append(obligation)
        if self._within is not None:
            due = obligation.since + round(self._within * NANOSECONDS)
            obligation.alarm = self._timeline.alarm(due, Phase.EXPIRY, lambda at: self._expire(at, key, obligation))

    def meet(self, at: int, key: Hashable) -> None:
        """Close all obligations that are about something: they are met."""
        for obligation in self._open.pop(key, ()):
            self._close(at, obligation)

    def meet_those_that_hold(self, at: int) -> None:
        """Close the obligations whose own term holds now."""
        for key in [*self._open]:
            left: list[Obligation] = []
            for obligation in self._open[key]:
                if obligation.term is not None:
                    obligation.term.look()
                if obligation.term is not None and obligation.term.holds:
                    self._close(at, obligation)
                else:
                    left.append(obligation)
            if left:
                self._open[key] = left
            else:
                del self._open[key]

    @property
    def open(self) -> list[Obligation]:
        """Those that are open, in order."""
        found = [obligation for obligations in self._open.values() for obligation in obligations]
        return sorted(found, key=lambda obligation: obligation.since)

    def _close(self, at: int, obligation: Obligation) -> None:
        if obligation.alarm is not None:
            obligation.alarm.cancel()
        if obligation.term is not None:
            obligation.term.close()
        if self._within:
            self.least = min(self.least, 1.0 - (at - obligation.since) / NANOSECONDS / self._within)

    def _expire(self, at: int, key: Hashable, obligation: Obligation) -> None:
        if obligation.term is not None:
            obligation.term.close()
        left = [each for each in self._open.get(key, ()) if each is not obligation]
        if left:
            self._open[key] = left
        else:
            self._open.pop(key, None)
        self._expired(at, obligation)
