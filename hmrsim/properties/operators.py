"""Properties by temporal operators: always, never, eventually, sometimes, and reports."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from hmrsim.diagnostics import listed
from hmrsim.events import EventPattern
from hmrsim.events.simulation import RunReported
from hmrsim.geometry import PlaceNames
from hmrsim.history.timeline import GoalSeen
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.properties.model.conditions import RobotCondition
from hmrsim.properties.model.part import walk
from hmrsim.properties.signals import FAILS, HOLDS, watch
from hmrsim.properties.temporal import Above, And, Formula, Not, Or, Previous
from hmrsim.properties.terms import Term
from hmrsim.properties.watcher import Obligation, Obligations, Watcher, cut_off

if TYPE_CHECKING:
    from hmrsim.events import Event
    from hmrsim.properties.observations import Observations
    from hmrsim.properties.results import Ended, OnViolation, Verdict
    from hmrsim.world.model import World

_FAR: Final = 9.0
"""Radii of the circle around a place beyond which a robot is far from it."""


@dataclass(frozen=True)
class Instance:
    """A property to watch: that of a file, or for one robot if it is about each.

    Attributes:
        template: The property as the file has it, with ``*`` for each robot.
        robot: The robot that it is about; empty for none.
    """

    name: str
    part: Any
    template: Any
    robot: str
    observations: Observations
    on_violation: OnViolation


class Temporal(Watcher):
    """A property about conditions, which are evaluated at the end of each instant at which one may have changed.

    Args:
        fields: The fields of the property with these conditions.

    Attributes:
        subject: The robot that the property is about; empty for none.
        over: Whether nothing that comes can change the verdict.
    """

    def __init__(self, of: Instance, *fields: str) -> None:
        super().__init__(of.name, of.on_violation)
        self.part, self.subject = of.part, of.robot
        self.observations = of.observations
        self.timeline = of.observations.timeline
        self.terms = [
            Term(getattr(of.part, field), of.observations, self.mark, getattr(of.template, field)) for field in fields
        ]
        self.began = 0
        self.over = False

    def mark(self) -> None:
        """Evaluate the conditions at the end of this instant."""
        self.timeline.settle(self.settled)

    def begin(self, at: int) -> None:
        """Evaluate the conditions at the first instant."""
        self.began = at
        self.mark()

    def settled(self, at: int) -> None:
        """Evaluate the conditions at the end of an instant."""
        if not self.over:
            for term in self.terms:
                term.look()
            self._step(at)

    def _step(self, at: int) -> None:
        """Take the values of the conditions at the end of an instant."""
        raise NotImplementedError


class Liveness(Temporal):
    """A property by which something has to happen: once or each time, within a time limit or at any time.

    Args:
        within: Seconds within which each demand has to be met; 0 for at once, None for any time.

    Attributes:
        missing: What is demanded and has not come yet.
        undecided: How many demands were open when the run ended too early.
    """

    def __init__(self, of: Instance, *fields: str, within: float | None) -> None:
        super().__init__(of, *fields)
        self._within = within
        self.missing: Obligations[Any] = Obligations(self.timeline, within, self._expire)
        self.undecided = 0

    def end(self, at: int, ended: Ended | None) -> None:
        """Report each demand that was never met, if it had all the time of the run."""
        for obligation in self.missing.open:
            if self._within is None and not cut_off(ended):
                self._miss(at, obligation, "never")
            else:
                self.undecided += 1

    def _expire(self, at: int, obligation: Obligation[Any]) -> None:
        self._miss(at, obligation, f"not within {self._within:g} s" if self._within else "not at once")

    def _miss(self, at: int, obligation: Obligation[Any], late: str) -> None:
        """Report a demand that is not met in time; *late* is "never", "not at once" or "not within 5 s"."""
        raise NotImplementedError


class Clause(NamedTuple):
    """A formula that has to hold at each instant.

    Attributes:
        formula: The formula, without windows; its signals are those of `Clauses`.
        reason: Why an instant violates it, without times and robots.
        text: Why, as a sentence; the reason if left out.
    """

    formula: Formula
    reason: str
    text: str = ""


class Clauses:
    """The clauses of a property, monitored from one instant to the next.

    Args:
        signals: The names of the signals in samples.

    Attributes:
        least: The least robustness so far, 1 at most.
    """

    def __init__(self, clauses: Iterable[Clause], signals: Sequence[str]) -> None:
        self._values = [(clause.formula.value(signals), clause) for clause in clauses]
        self.least = 1.0

    def broken(self, sample: Sequence[float]) -> Clause | None:
        """Take a sample; return the first clause that it violates."""
        broken = None
        for value, clause in self._values:
            robustness = value(sample)
            self.least = min(self.least, robustness)
            if robustness <= 0.0 and broken is None:
                broken = clause
        return broken


A, B = Above("a"), Above("b")
"""The first and the second condition of a property."""

_OF_TERMS: Final = ("a", "begins", "b")


def begins(part: Formula) -> Formula:
    """Return whether the first condition of a formula begins to hold, or holds once more."""
    return And(part, Or(Not(Previous(part)), Above("begins")))


_HOLDS: Final = Clause(Or(A, Previous(Not(A))), "not: {a}", "it is not true that {a}")
_NEVER_BEGINS: Final = Clause(Not(begins(A)), "{a}", "{a}")


class Invariant(Temporal):
    """Clauses about one condition or two that hold at each instant.

    Args:
        clauses: The clauses; ``{a}`` and ``{b}`` in their texts stand for the conditions.
    """

    def __init__(self, of: Instance, clauses: Iterable[Clause], *fields: str) -> None:
        super().__init__(of, *fields)
        self.clauses = Clauses(clauses, _OF_TERMS)
        self._events: list[Event | GoalSeen] = []
        self._events_at = 0
        for _, part in walk(getattr(of.part, fields[0])):
            if isinstance(part, EventPattern):
                watch(self.timeline, part, self._note)

    def _note(self, at: int, event: Event | GoalSeen) -> None:
        if at > self._events_at:
            self._events_at = at
            self._events.clear()
        self._events.append(event)

    def _step(self, at: int) -> None:
        first, second = self.terms[0], self.terms[-1]
        broken = self.clauses.broken((first.value, HOLDS if first.hits else FAILS, second.value))
        if broken is not None:
            reason = broken.reason.format(a=first.words, b=second.words)
            text = broken.text.format(a=first.text, b=second.text)
            subject = self.subject
            if self._events and self._events_at == at:
                subject = subject or _subject_of(self._events[0])
                events = [_described(event, self.observations.world) for event in self._events]
                text = f"{text}, at {at / NANOSECONDS:g} s: {listed(events)}"
            self.violate(at, subject, reason, text)


def _subject_of(event: Event | GoalSeen) -> str:
    return event.robot if isinstance(event, GoalSeen) else event.subject


def _described(event: Event | GoalSeen, world: World) -> str:
    """Return an event or the change of a goal as text, with the place if the event has one."""
    if isinstance(event, GoalSeen):
        return f"{event.action} of {event.robot}"
    at = event.as_dict().get("at")
    place = f" at {PlaceNames(world.points).of((at[0], at[1]))}" if isinstance(at, tuple) else ""
    return f"{event.describe()}{place}"


class Always(Invariant):
    """G a: each time that the condition ceases to hold is a violation."""

    def __init__(self, of: Instance) -> None:
        super().__init__(of, [_HOLDS], "always")

    def _unless_violated(self) -> Verdict:
        return self._is("holds", self.clauses.least, f"always {self.terms[0].text}")


class Never(Invariant):
    """G not a: each time that the condition begins to hold is a violation, and so is each event."""

    def __init__(self, of: Instance, field: str = "never") -> None:
        super().__init__(of, [_NEVER_BEGINS], field)
        self._clearance: Callable[[], float] | None = None
        condition = getattr(of.part, field)
        if isinstance(condition, RobotCondition) and condition.at is not None and condition.is_ is None:
            self._clearance = partial(of.observations.positions.clearance, condition.robot, condition.at)

    def _unless_violated(self) -> Verdict:
        """Return that it holds; the robustness is that of the opposite, or how far a robot stayed away."""
        least = self.clauses.least
        if self._clearance is not None:
            least = min(least, self._clearance() / _FAR)
        return self._is("holds", least, f"never {self.terms[0].text}")


class Eventually(Liveness):
    """F[0, within] a: the condition holds at some instant."""

    def __init__(self, of: Instance) -> None:
        super().__init__(of, "eventually", within=of.part.within)

    def begin(self, at: int) -> None:
        """Begin to wait for the condition."""
        super().begin(at)
        self.missing.add(Obligation(at, None))

    def _step(self, at: int) -> None:
        if self.terms[0].holds:
            self.missing.meet(at, None)
            self.over = True

    def _miss(self, at: int, _obligation: Obligation[Any], late: str) -> None:
        term, when = self.terms[0], "never true" if late == "never" else f"not true{late.removeprefix('not')}"
        self.violate(at, self.subject, f"{late}: {term.words}", f"it was {when} that {term.text}")

    def _unless_violated(self) -> Verdict:
        """Return whether the condition has held; the robustness is the share of the time that was left."""
        text = self.terms[0].text
        if self.missing:
            return self._is("undecided", 0.0, f"it was not true by the end that {text}")
        return self._is("holds", self.missing.least, f"after {self.missing.seconds:.1f} s {text}")


class Sometimes(Temporal):
    """A condition should hold at some instant of some run; this is never violated."""

    def __init__(self, of: Instance) -> None:
        super().__init__(of, "sometimes")

    def _step(self, at: int) -> None:
        """Do nothing; the condition counts how often it begins to hold."""

    def _unless_violated(self) -> Verdict:
        term = self.terms[0]
        if not term.times:
            return self._is("never_exercised", 0.0, f"it was never true that {term.text}")
        return self._is("holds", 1.0, f"{term.text}, {'once' if term.times == 1 else f'{term.times} times'}")


class Reports(Temporal):
    """A condition holds whenever the controller reports an outcome: as it ends, or by `end_run`."""

    def __init__(self, of: Instance) -> None:
        super().__init__(of, "then")
        self._report = of.part.reports
        self._reports = self._judged = 0
        self._known = False
        self.timeline.on(RunReported, self._hear)

    def _hear(self, _at: int, event: RunReported) -> None:
        if event.label == self._report:
            self._reports += 1
            self.mark()

    def _step(self, at: int) -> None:
        if self._reports > self._judged:
            self._judged = self._reports
            self._judge(at)

    def end(self, at: int, ended: Ended | None) -> None:
        """Judge the end of the controller, which is its report as well."""
        self._known = ended is not None and not cut_off(ended)
        if ended is not None and ended.ending == self._report:
            self._reports += 1
            self._judge(at)

    def _judge(self, at: int) -> None:
        term = self.terms[0]
        if not term.holds:
            reason = f"reported {self._report}, but not: {term.words}"
            text = f"the controller reports {self._report}, but it is not true that {term.text}"
            self.violate(at, self.subject, reason, text)

    def _unless_violated(self) -> Verdict:
        if self._reports:
            return self._is("holds", 1.0, f"the controller reported {self._report}, and {self.terms[0].text}")
        if not self._known:
            return self._is("undecided", 0.0, f"it is not known whether the controller ends as {self._report}")
        return self._is("never_exercised", 1.0, f"the controller never reported {self._report}")
