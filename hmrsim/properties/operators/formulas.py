"""Formulas with windows of time, monitored while the run goes on."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.properties import temporal
from hmrsim.properties.conditions.expressions import Expression
from hmrsim.properties.conditions.wording import describe
from hmrsim.properties.model.formulas import AnyOne, Conditional, Every, Opposite, Sometime, Throughout, UpTo
from hmrsim.properties.observing.timeline import Phase
from hmrsim.properties.operators.settling import Settling
from hmrsim.properties.watcher import cut_off

if TYPE_CHECKING:
    from pydantic import BaseModel

    from hmrsim.properties.observing.observations import Observations
    from hmrsim.properties.results import Ended, Tell, Verdict
    from hmrsim.properties.robustness import Changes

_ALL_TIME: Final = (0, math.inf)


class Following(Settling):
    """A formula holds at the start of the run; one that is always to hold, at each time.

    Args:
        formula: The formula.
        words: The same in words that are the same for each robot.
    """

    def __init__(
        self, name: str, subject: str, formula: BaseModel, words: str, observations: Observations, tell: Tell
    ) -> None:
        super().__init__(name, subject, observations, tell)
        self._always = isinstance(formula, Throughout) and formula.within is None
        self._reason, self._said = f"not: {words}", in_words(formula)
        self._expressions: list[Expression] = []
        inner = formula.always if isinstance(formula, Throughout) and self._always else formula
        made = self._made(inner)
        self._monitor = temporal.OnlineMonitor(made, [str(i) for i in range(len(self._expressions))])
        self._horizon = 0 if math.isinf(made.horizon) else int(made.horizon)
        self._waits = False
        self._at = -1
        self._least = math.inf
        self._fails = False
        self._undecided = False
        for expression in self._expressions:
            for signal in expression.signals:
                signal.tell(self.mark)

    def settled(self, at: int) -> None:
        """Take the values of all conditions at an instant."""
        if at <= self._at:
            return
        self._at = at
        changes = self._monitor.update(at, [expression.value() for expression in self._expressions])
        self._take(at, changes)
        self._wait()

    def _wait(self) -> None:
        """Look again where what holds now has decided, also if nothing changes any more."""
        if self._horizon and not self._waits:
            self._waits = True
            self.timeline.alarm(self._at + self._horizon, Phase.CHANGE, self._look_again)

    def _look_again(self, at: int) -> None:
        self._waits = False
        if at - self._at >= self._horizon:
            self.mark()
        else:
            self._wait()

    def end(self, at: int, ended: Ended | None) -> None:
        """Judge what is certain now; what an end cuts off is not."""
        self.settled(at)
        certain = not math.isinf(self._least)
        if cut_off(ended):
            self._undecided = not certain
            return
        least, greatest = self._monitor.finish()
        if self._is_open(at):
            self._take(at, [change for change in greatest if change[1] <= 0.0 and change[0] <= at][:1])
        self._undecided = not certain and any(value <= 0.0 for time, value in least if time <= at)
        if not certain and not self._undecided:
            self._least = min((value for time, value in least if time <= at), default=1.0)

    def _is_open(self, at: int) -> bool:
        """Return whether something at the start, or at a time of the run, is still to be judged."""
        return bool(self._monitor.known < (at if self._always else self.began))

    def _take(self, now: int, changes: Changes) -> None:
        for at, value in changes:
            if not self._always and at > self.began:
                return
            self._least = min(self._least, value)
            failed, self._fails = self._fails, value <= 0.0
            if self._fails and not failed:
                text = f"it is not so at {at / NANOSECONDS:.1f} s that {self._said}"
                self.violate(now, self.subject, self._reason, text)

    def unless_violated(self) -> Verdict:
        """Return whether it holds; the robustness is that of the formula."""
        if self._undecided or math.isinf(self._least):
            return self._is("undecided", 0.0, f"the run ended before it was certain that {self._said}")
        return self._is("holds", self._least, self._said)

    def _made(self, part: BaseModel) -> temporal.Formula:
        match part:
            case Throughout(always=inner, within=window):
                return temporal.Always(*_window(window), self._made(inner))
            case Sometime(eventually=inner, within=window):
                return temporal.Eventually(*_window(window), self._made(inner))
            case UpTo(hold=left, until=right, within=window):
                return temporal.Until(*_window(window), self._made(left), self._made(right))
        return self._combined(part)

    def _combined(self, part: BaseModel) -> temporal.Formula:
        match part:
            case Conditional(if_=left, then=right):
                return temporal.Implies(self._made(left), self._made(right))
            case Opposite(not_=inner):
                return temporal.Not(self._made(inner))
            case Every(all=parts):
                return _joined(temporal.And, [self._made(each) for each in parts])
            case AnyOne(any=parts):
                return _joined(temporal.Or, [self._made(each) for each in parts])
        self._expressions.append(Expression(part, self.observations))
        return temporal.Above(str(len(self._expressions) - 1))


def _window(window: tuple[float, float] | None) -> tuple[float, float]:
    if window is None:
        return _ALL_TIME
    return round(window[0] * NANOSECONDS), round(window[1] * NANOSECONDS)


def _joined(kind: type[temporal.And | temporal.Or], parts: list[temporal.Formula]) -> temporal.Formula:
    whole = parts[0]
    for part in parts[1:]:
        whole = kind(whole, part)
    return whole


def in_words(part: BaseModel) -> str:
    """Return a formula as text."""
    match part:
        case Throughout(always=inner, within=window):
            return f"always{_for(window)} ({in_words(inner)})"
        case Sometime(eventually=inner, within=window):
            return f"eventually{_for(window)} ({in_words(inner)})"
        case UpTo(hold=left, until=right, within=window):
            return f"({in_words(left)}) until{_for(window)} ({in_words(right)})"
        case Conditional(if_=left, then=right):
            return f"if {in_words(left)} then {in_words(right)}"
    return _combined(part)


def _combined(part: BaseModel) -> str:
    match part:
        case Opposite(not_=inner):
            return f"not ({in_words(inner)})"
        case Every(all=parts):
            return " and ".join(map(in_words, parts))
        case AnyOne(any=parts):
            return " or ".join(map(in_words, parts))
    return describe(part)


def _for(window: tuple[float, float] | None) -> str:
    if window is None:
        return ""
    return f" within {window[1]:g} s" if not window[0] else f" from {window[0]:g} to {window[1]:g} s on"
