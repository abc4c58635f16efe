"""Patterns of missions as formulas of the temporal engine, and properties about each trigger.

A pattern that forbids something has clauses, formulas of the past that have to hold at each instant. A pattern that
demands something has obligations. The published formulas are on http://roboticpatterns.com.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

from hmrsim.events import EventPattern
from hmrsim.properties.model.part import BOUND, bound, bound_names
from hmrsim.properties.operators import A, B, Clause, Instance, Invariant, Liveness, Temporal, begins
from hmrsim.properties.signals import fields_of, watch
from hmrsim.properties.temporal import And, Implies, Not, Once, Or, Previous
from hmrsim.properties.terms import Term, prepare
from hmrsim.properties.watcher import Obligation, cut_off

if TYPE_CHECKING:
    from hmrsim.events import Event
    from hmrsim.history.timeline import GoalSeen
    from hmrsim.properties.model.conditions import Condition
    from hmrsim.properties.results import Ended, Verdict


_NOT_BEFORE: Final = Clause(Or(Not(A), Once(B)), "{a} before {b}", "{a} before {b}")
_UP_TO: Final = Clause(Or(A, Once(B)), "{a} no longer, before {b}", "{a} no longer, before {b}")
_NOT_AFTER: Final = Clause(Not(begins(And(Once(B), A))), "{a} after {b}", "{a} after {b}")


class HeldUntil(Invariant):
    """A condition holds, or is avoided, until another one holds: a U b, or (not a) U b; the first violation counts.

    Args:
        field: The field with the first condition.
        avoided: Whether it must not hold.
    """

    def __init__(self, of: Instance, field: str, *, avoided: bool) -> None:
        super().__init__(of, [_NOT_BEFORE if avoided else _UP_TO], field, "until")
        self._avoided = avoided

    def _step(self, at: int) -> None:
        super()._step(at)
        self.over = self.terms[1].holds or self.first is not None

    def end(self, at: int, ended: Ended | None) -> None:
        """Report a violation if the other condition has never held."""
        if not (self.over or cut_off(ended)):
            until = self.terms[1]
            self.violate(at, self.subject, f"never: {until.words}", f"it was never true that {until.text}")

    def _unless_violated(self) -> Verdict:
        held, until = self.terms
        if not self.over:
            return self._is("undecided", 0.0, f"it was not true by the end that {until.text}")
        return self._is("holds", 1.0, f"until {until.text} it was {'not ' * self._avoided}so that {held.text}")


class AvoidedAfter(Invariant):
    """A condition never holds again once another one has held: G (b -> G not a)."""

    def __init__(self, of: Instance) -> None:
        super().__init__(of, [_NOT_AFTER], "future_avoidance", "after")

    def _unless_violated(self) -> Verdict:
        avoided, after = self.terms
        if not after.times:
            return self._is("never_exercised", 1.0, f"it was never true that {after.text}")
        return self._is("holds", 1.0, f"since {after.text} it was not true that {avoided.text}")


class Counted(Temporal):
    """A condition begins to hold at least so many times, or at most so many times."""

    def __init__(self, of: Instance, field: str, *, least: bool = False, most: bool = False) -> None:
        super().__init__(of, field)
        self._least: int = of.part.count if least else 0
        self._most: float = of.part.count if most else math.inf

    def _step(self, at: int) -> None:
        term = self.terms[0]
        if term.times - term.hits <= self._most < term.times:
            text = f"it is so for the {term.times}. time that {term.text}"
            self.violate(at, self.subject, f"more than {self._most:g} times: {term.words}", text)

    def end(self, at: int, ended: Ended | None) -> None:
        """Report a violation if the condition has not begun to hold often enough."""
        term = self.terms[0]
        if term.times < self._least and not cut_off(ended):
            text = f"it was so {term.times} times, and not {self._least} times, that {term.text}"
            self.violate(at, self.subject, f"less than {self._least} times: {term.words}", text)

    def _unless_violated(self) -> Verdict:
        """Return how often it began; the robustness is the share of *most* that was left."""
        term = self.terms[0]
        text = f"it was so {term.times} times that {term.text}"
        if term.times < self._least:
            return self._is("undecided", 0.0, text)
        bounded = self._least == 0 and not math.isinf(self._most)
        return self._is("holds", (self._most - term.times) / self._most if bounded else 1.0, text)


_NOT_AT_ONCE: Final = Clause(Implies(A, B), "not at once: {b}", "{a}, and not at once {b}")
_NOT_NEXT: Final = Clause(Implies(Previous(A), B), "not next: {b}", "{a}, and not next {b}")

REACTIONS: Final[Mapping[str, Sequence[Clause]]] = MappingProxyType(
    {
        "instantaneous_reaction": [_NOT_AT_ONCE],
        "bound_reaction": [_NOT_AT_ONCE, Clause(Implies(B, A), "without cause: {b}", "{b}, and not {a}")],
        "prompt_reaction": [_NOT_NEXT],
        "bound_delay": [
            _NOT_NEXT,
            Clause(Implies(B, Previous(A, initially=True)), "without cause: {b}", "{b}, and not before {a}"),
        ],
    }
)
"""The clauses of reactions at an instant, by the field with the stimulus; *a* is the stimulus and *b* the reaction."""


class Reaction(Invariant):
    """A reaction holds at the instant of a stimulus, or at the next one."""

    def __init__(self, of: Instance, field: str) -> None:
        super().__init__(of, REACTIONS[field], field, "then")
        self._next = _NOT_NEXT in REACTIONS[field]

    def _unless_violated(self) -> Verdict:
        stimulus = self.terms[0]
        if not stimulus.times:
            return self._is("never_exercised", 1.0, f"it was never true that {stimulus.text}")
        if self._next and stimulus.holds and stimulus.times == 1:
            return self._is("undecided", 0.0, f"nothing has followed since {stimulus.text}")
        return self._is("holds", 1.0, f"{stimulus.times} times {stimulus.text}")


class DelayedReaction(Liveness):
    """A reaction holds at the time of a stimulus or later: G (a -> F[0, within] b)."""

    def __init__(self, of: Instance) -> None:
        super().__init__(of, "delayed_reaction", "then", within=of.part.within)

    def _step(self, at: int) -> None:
        stimulus, reaction = self.terms
        if reaction.holds:
            self.missing.meet(at, None)
        elif stimulus.holds and not self.missing:
            self.missing.add(Obligation(at, None))

    def _miss(self, at: int, _obligation: Obligation[Any], late: str) -> None:
        stimulus, reaction = self.terms
        self.violate(at, self.subject, f"{late}: {reaction.words}", f"{stimulus.text}, and {late} {reaction.text}")

    def _unless_violated(self) -> Verdict:
        """Return the verdict on all reactions; the robustness is the least share of the time that was left."""
        stimulus, reaction = self.terms
        if self.undecided:
            return self._is("undecided", 0.0, f"it was not true by the end that {reaction.text}")
        if not stimulus.times:
            return self._is("never_exercised", 1.0, f"it was never true that {stimulus.text}")
        return self._is("holds", self.missing.least, f"{stimulus.times} times {stimulus.text}")


class Whenever(Liveness):
    """Each time that a trigger begins to hold, another condition has to hold then or later.

    Of two events at one instant the second one follows the first. A trigger that is not an event begins to hold at the
    end of an instant, and everything that holds or comes at that instant follows it.

    Args:
        trigger: The field with the trigger.
        within: Seconds; None for any time.
    """

    def __init__(self, of: Instance, trigger: str, within: float | None) -> None:
        self._then: Condition = of.part.then
        condition = getattr(of.part, trigger)
        self._names = bound_names(self._then)
        by_event, event_follows = isinstance(condition, EventPattern), isinstance(self._then, EventPattern)
        fields = [*([] if by_event else [trigger]), *([] if event_follows or self._names else ["then"])]
        super().__init__(of, *fields, within=within)
        self._trigger = None if by_event else self.terms[0]
        self._term = self.terms[-1] if "then" in fields else None
        self._words, self._trigger_text = of.template.then.describe(), condition.describe()
        self._keys: list[tuple[str, str]] = []
        self._met: dict[Hashable, int] = {}
        if isinstance(condition, EventPattern):
            watch(self.timeline, condition, self._begin_at_event)
        if isinstance(self._then, EventPattern):
            pattern, self._keys = _opened(self._then)
            watch(self.timeline, pattern, self._meet_at_event)
        elif self._names:
            prepare(self._then, of.observations)

    def _begin_at_event(self, at: int, event: Event | GoalSeen) -> None:
        self._begin(at, fields_of(event) if self._names or not self.subject else {})

    def _begin(self, at: int, fields: Mapping[str, Any]) -> None:
        then = bound(self._then, fields) if self._names else self._then
        subject = self.subject or str(fields.get("robot") or fields.get("order") or "")
        key = tuple(_hashable(fields.get(name)) for _, name in self._keys)
        obligation = Obligation(at, key, subject, then.describe())
        if self._names and not isinstance(then, EventPattern):
            obligation.term = Term(then, self.observations, self.mark)
        self.missing.add(obligation)
        self.mark()

    def _meet_at_event(self, at: int, event: Event | GoalSeen) -> None:
        if self._trigger is None and not self.missing:
            return
        values = fields_of(event) if self._keys else {}
        key = tuple(_hashable(values.get(field)) for field, _ in self._keys)
        if self._trigger is not None:
            self._met[key] = at
            self.mark()
        self.missing.meet(at, key)

    def _step(self, at: int) -> None:
        if self._trigger is not None:
            if self._trigger.hits:
                self._begin(at, {})
            if self._met.get(()) == at:
                self.missing.meet(at, ())
        if self._term is not None:
            if self._term.holds:
                self.missing.meet(at, ())
        elif self._names and not self._keys:
            self.missing.meet_terms(at)

    def _miss(self, at: int, obligation: Obligation[Any], late: str) -> None:
        text = f"{self._trigger_text} at {obligation.since / 1e9:.1f} s, and {late} {obligation.text}"
        self.violate(at, obligation.subject, f"{late}: {self._words}", text)

    def _unless_violated(self) -> Verdict:
        """Return the verdict on all triggers; the robustness is the least share of the time that was left."""
        count = self.missing.count
        if not count:
            return self._is("never_exercised", 1.0, f"it was never true that {self._trigger_text}")
        if self.undecided:
            return self._is("undecided", 0.0, f"{self.undecided} of {count} times it had not followed by the end")
        return self._is("holds", self.missing.least, f"followed each time, {count} in all")


def _opened(then: EventPattern) -> tuple[EventPattern, list[tuple[str, str]]]:
    """Return a pattern without its bound fields, and pairs of each bound field and the trigger's field."""
    keys, where = list[tuple[str, str]](), dict[str, Any]()
    for field, value in then.where.items():
        if isinstance(value, str) and value.startswith(BOUND):
            keys.append((field, value[1:]))
        else:
            where[field] = value
    update: dict[str, Any] = {"where": where}
    for field in ("robot", "action"):
        value = getattr(then, field)
        if isinstance(value, str) and value.startswith(BOUND):
            keys.append((field, value[1:]))
            update[field] = None
    return then.model_copy(update=update), keys


def _hashable(value: Any) -> Hashable:
    return tuple(value) if isinstance(value, list) else value if isinstance(value, Hashable) else repr(value)
