"""Formulas with windows of time, monitored while the run goes on."""

from __future__ import annotations

import math
from functools import reduce
from typing import TYPE_CHECKING, Final, cast

from hmrsim.history.timeline import Phase
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.properties import temporal
from hmrsim.properties.model.formulas import AnyOne, Conditional, Every, Opposite, Sometime, Throughout, UpTo
from hmrsim.properties.operators import Instance, Temporal
from hmrsim.properties.terms import Expression
from hmrsim.properties.watcher import cut_off

if TYPE_CHECKING:
    from hmrsim.properties.model.conditions import Condition
    from hmrsim.properties.model.formulas import FormulaPart
    from hmrsim.properties.results import Ended, Verdict
    from hmrsim.properties.robustness import Changes

_ALL_TIME: Final = (0, math.inf)


class Windows(Temporal):
    """A property that a formula with windows of time holds at the start of the run, or at all times."""

    def __init__(self, of: Instance) -> None:
        super().__init__(of)
        formula: FormulaPart = of.part.formula
        self._always = isinstance(formula, Throughout) and formula.within is None
        self._reason, self._text = f"not: {of.template.formula.describe()}", formula.describe()
        self._expressions: list[Expression] = []
        inner = formula.always if isinstance(formula, Throughout) and self._always else formula
        translated = self._translated(inner)
        self._monitor = temporal.OnlineMonitor(translated, [str(i) for i in range(len(self._expressions))])
        self._horizon = 0 if math.isinf(translated.horizon) else int(translated.horizon)
        self._waits = False
        self._at = -1
        self._least = math.inf
        self._fails = False
        self._undecided = False
        for expression in self._expressions:
            for signal in expression.signals:
                signal.subscribe(self.mark)

    def _step(self, at: int) -> None:
        if at > self._at:
            self._at = at
            self._take(at, self._monitor.update(at, [expression.value() for expression in self._expressions]))
            self._wait()

    def _wait(self) -> None:
        """Evaluate the conditions again once a horizon has passed, also if nothing changes until then."""
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
        """Judge the times whose windows the run covers, and no others."""
        self._step(at)
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
        """Return whether the start, or a time of the run, is still to be judged."""
        return bool(self._monitor.known < (at if self._always else self.began))

    def _take(self, now: int, changes: Changes) -> None:
        for at, value in changes:
            if not self._always and at > self.began:
                return
            self._least = min(self._least, value)
            failed, self._fails = self._fails, value <= 0.0
            if self._fails and not failed:
                text = f"it is not so at {at / NANOSECONDS:.1f} s that {self._text}"
                self.violate(now, self.subject, self._reason, text)

    def _unless_violated(self) -> Verdict:
        if self._undecided or math.isinf(self._least):
            return self._is("undecided", 0.0, f"the run ended before it was certain that {self._text}")
        return self._is("holds", self._least, self._text)

    def _translated(self, part: FormulaPart) -> temporal.Formula:
        """Return a formula of the temporal engine, with a signal for each condition."""
        match part:
            case Throughout(always=inner, within=window):
                return temporal.Always(*_window(window), self._translated(inner))
            case Sometime(eventually=inner, within=window):
                return temporal.Eventually(*_window(window), self._translated(inner))
            case UpTo(hold=left, until=right, within=window):
                return temporal.Until(*_window(window), self._translated(left), self._translated(right))
        return self._combined(part)

    def _combined(self, part: FormulaPart) -> temporal.Formula:
        match part:
            case Conditional(if_=left, then=right):
                return temporal.Implies(self._translated(left), self._translated(right))
            case Opposite(not_=inner):
                return temporal.Not(self._translated(inner))
            case Every(all=parts):
                return reduce(temporal.And, map(self._translated, parts))
            case AnyOne(any=parts):
                return reduce(temporal.Or, map(self._translated, parts))
        self._expressions.append(Expression(cast("Condition", part), self.observations))
        return temporal.Above(str(len(self._expressions) - 1))


def _window(window: tuple[float, float] | None) -> tuple[float, float]:
    if window is None:
        return _ALL_TIME
    return round(window[0] * NANOSECONDS), round(window[1] * NANOSECONDS)
