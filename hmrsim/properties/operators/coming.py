"""Eventually, and sometimes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.properties.conditions.wording import describe
from hmrsim.properties.observing.timeline import Phase
from hmrsim.properties.operators.settling import Settling
from hmrsim.properties.watcher import cut_off

if TYPE_CHECKING:
    from pydantic import BaseModel

    from hmrsim.properties.observing.observations import Observations
    from hmrsim.properties.results import Ended, Tell, Verdict


class Coming(Settling):
    """A condition holds at some instant.

    Args:
        words: The condition in words that are the same for each robot.
        within: Seconds from the start; None for any time.
    """

    def __init__(
        self,
        name: str,
        subject: str,
        condition: BaseModel,
        words: str,
        observations: Observations,
        tell: Tell,
        *,
        within: float | None = None,
    ) -> None:
        super().__init__(name, subject, observations, tell)
        self._words, self._said = words, describe(condition)
        self._within = within
        self._term = self.term(condition)
        self._came: int | None = None
        self._over = 0

    def begin(self, at: int) -> None:
        """Look at the first instant, and begin to wait."""
        super().begin(at)
        if self._within is not None:
            self.timeline.alarm(at + round(self._within * NANOSECONDS), Phase.EXPIRY, self._expire)

    def settled(self, at: int) -> None:
        """Look whether the condition has come to hold."""
        if self._came is None:
            self._term.look()
            if self._term.holds:
                self._came = at

    def _expire(self, at: int) -> None:
        if self._came is None:
            reason = f"not within {self._within:g} s: {self._words}"
            self.violate(at, self.subject, reason, f"it was not so within {self._within:g} s that {self._said}")

    def end(self, at: int, ended: Ended | None) -> None:
        """Tell if it has never come, and had all the time of the run."""
        self._over = at
        if self._came is None and self._within is None and not cut_off(ended):
            self.violate(at, self.subject, f"never: {self._words}", f"it was never so that {self._said}")

    def unless_violated(self) -> Verdict:
        """Return whether it has come; the robustness is the share of the time that was left."""
        until = self._over if self._came is None else self._came
        seconds = (until - self.began) / NANOSECONDS
        left = 1.0 if self._within is None else 1.0 - seconds / self._within
        if self._came is None:
            return self._is("undecided", min(left, 0.0), f"it was not so by the end that {self._said}")
        return self._is("holds", left, f"after {seconds:.1f} s {self._said}")


class Happening(Settling):
    """A condition should hold at some instant of some run, which is never violated."""

    def __init__(self, name: str, subject: str, condition: BaseModel, observations: Observations, tell: Tell) -> None:
        super().__init__(name, subject, observations, tell)
        self._said = describe(condition)
        self._term = self.term(condition)
        self._times = 0

    def settled(self, _at: int) -> None:
        """Count how often it begins to hold."""
        self._term.look()
        self._times += self._term.hits

    def unless_violated(self) -> Verdict:
        """Return whether it has happened."""
        if not self._times:
            return self._is("never_exercised", 0.0, f"it was never so that {self._said}")
        often = "once" if self._times == 1 else f"{self._times} times"
        return self._is("holds", 1.0, f"{self._said}, {often}")
