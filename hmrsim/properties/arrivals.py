"""Properties about the places that a robot reaches: visits and patrols.

Clauses, past-time formulas about arrivals, restrict the order in which it may reach them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final

from hmrsim.properties.model.conditions import RobotCondition
from hmrsim.properties.operators import Clause, Clauses, Instance, Liveness
from hmrsim.properties.signals import FAILS, HOLDS
from hmrsim.properties.temporal import Above, And, Formula, Implies, Not, Previous, Since
from hmrsim.properties.terms import Term
from hmrsim.properties.watcher import Obligation

if TYPE_CHECKING:
    from hmrsim.properties.results import Verdict


Order = Callable[[Sequence[Formula]], list[Clause]]
"""Returns the clauses that restrict the order of arrivals at some places."""

_REACHED: Final = "reached"
"""The signal with the number of places of the current round that were reached before an arrival."""


def in_any_order(_places: Sequence[Formula]) -> list[Clause]:
    """Return no clauses: any order is allowed."""
    return []


def in_order(places: Sequence[Formula]) -> list[Clause]:
    """Forbid reaching a place before its predecessor: (not l2) U l1, and so on."""
    return [Clause(Implies(place, Above(_REACHED, i - 0.5)), "too early") for i, place in enumerate(places)]


def in_strict_order(places: Sequence[Formula]) -> list[Clause]:
    """Also forbid reaching a place again before the next one: (not l1) U (l1 and X ((not l1) U l2)), and so on."""
    again = [
        Implies(And(place, Above(_REACHED, i + 0.5)), Above(_REACHED, i + 1.5)) for i, place in enumerate(places[:-1])
    ]
    return [*in_order(places), *(Clause(formula, "again too early") for formula in again)]


def fair(places: Sequence[Formula]) -> list[Clause]:
    """Forbid reaching a place again before the next one in a circle: G (l1 -> X ((not l1) W l2))."""
    return [_not_again(a, b) for a, b in _circle(places)]


def in_rounds(places: Sequence[Formula]) -> list[Clause]:
    """Require each place to follow its predecessor in a circle: (not l2) U l1, G (l2 -> X ((not l2) U l1)).

    The until is weak, as a patrol is unfinished when a run ends.
    """
    # At first, all places except the first one wait for their predecessor.
    return [
        Clause(
            Not(And(b, Previous(Since(Not(a), b, initially=b is not places[0]), initially=b is not places[0]))),
            "too early",
        )
        for a, b in _circle(places)
    ]


def in_strict_rounds(places: Sequence[Formula]) -> list[Clause]:
    """Also forbid reaching a place, except the last, again before the next one: G (l1 -> X ((not l1) U l2))."""
    return [*(_not_again(a, b) for a, b in pairwise(places)), *in_rounds(places)]


def _circle(places: Sequence[Formula]) -> list[tuple[Formula, Formula]]:
    """Return each place with the next one in a circle; none if there is only one place."""
    return [*pairwise([*places, places[0]])] if len(places) > 1 else []


def _not_again(a: Formula, b: Formula) -> Clause:
    """Forbid reaching *a* again before *b*."""
    return Clause(Not(And(a, Previous(Since(Not(b), a)))), "again too early")


class Round:
    """The places still to be reached in a round, in sequence or in any order."""

    def __init__(self, count: int, *, in_sequence: bool) -> None:
        self._count, self._in_sequence = count, in_sequence
        self._left: set[int] = {*range(count)}

    @property
    def next(self) -> int:
        """The first place still to be reached."""
        return min(self._left)

    @property
    def reached(self) -> int:
        """The number of places reached."""
        return self._count - len(self._left)

    def begin(self) -> None:
        """Begin a new round, in which every place counts again."""
        self._left.update(range(self._count))

    def arrive(self, place: int) -> bool:
        """Record an arrival, if it counts; return whether it completes the round."""
        if place not in self._left or (self._in_sequence and place != self.next):
            return False
        self._left.remove(place)
        return not self._left


class Arrivals(Liveness):
    """A property about the places that a robot reaches; those reached at one instant count in the order of the list.

    Args:
        field: The field of the property with the places.
        limit: The field with the time limit.
        order: Restricts the order of arrivals.
        in_sequence: Whether a place counts only after those before it.
    """

    def __init__(self, of: Instance, field: str, limit: str, order: Order, *, in_sequence: bool) -> None:
        super().__init__(of, within=getattr(of.part, limit))
        self.places: Sequence[str] = getattr(of.part, field)
        self.terms = [
            Term(RobotCondition(robot=self.subject, at=place), of.observations, self.mark) for place in self.places
        ]
        signals = [str(i) for i in range(len(self.places))]
        self._clauses = Clauses(order([Above(signal) for signal in signals]), [*signals, _REACHED])
        self.in_sequence, self.round = in_sequence, Round(len(self.places), in_sequence=in_sequence)

    def settled(self, at: int) -> None:
        """Process the arrivals and departures of an instant."""
        for i, term in enumerate(self.terms):
            was_there = term.holds
            term.look()
            if term.hits:
                arrivals = [HOLDS if i == j else FAILS for j in range(len(self.places))]
                broken = self._clauses.broken([*arrivals, self.round.reached])
                if broken is not None:
                    reason = f"{self.places[i]} {broken.reason}"
                    self.violate(at, self.subject, reason, f"{self.subject} reaches {reason}")
                self._arrive(at, i)
            elif was_there and not term.holds:
                self._leave(at, i)

    def _arrive(self, at: int, place: int) -> None:
        raise NotImplementedError

    def _leave(self, at: int, place: int) -> None:
        pass


class Visit(Arrivals):
    """A robot reaches all places, in sequence if *in_sequence*: F (l1 and F (l2 and ...)), or F l1 and F l2 and ..."""

    def begin(self, at: int) -> None:
        """Begin to wait for all places."""
        super().begin(at)
        self.missing.add(Obligation(at, None))

    def _arrive(self, at: int, place: int) -> None:
        if self.round.arrive(place):
            self.missing.meet(at, None)

    def _miss(self, at: int, _obligation: Obligation[Any], late: str) -> None:
        place, when = self.places[self.round.next], "by the end" if late == "never" else late.removeprefix("not ")
        self.violate(at, self.subject, f"{place} {late}", f"{self.subject} did not reach {place} {when}")

    def _unless_violated(self) -> Verdict:
        """Return whether all places were reached; the robustness is the share of the time limit that was left."""
        if self.missing:
            place = self.places[self.round.next]
            return self._is("undecided", 0.0, f"{self.subject} had not reached {place} by the end")
        text = f"{self.subject} reached all places after {self.missing.seconds:.1f} s"
        return self._is("holds", self.missing.least, text)


class Patrol(Arrivals):
    """A robot reaches places repeatedly: each in time, or all in sequence if *in_sequence*."""

    def __init__(self, of: Instance, field: str, limit: str, order: Order, *, in_sequence: bool) -> None:
        super().__init__(of, field, limit, order, in_sequence=in_sequence)
        self._rounds = 0
        self._visits = [0] * len(self.places)

    def begin(self, at: int) -> None:
        """Begin to wait for the first round."""
        super().begin(at)
        for place in self.places[:1] if self.in_sequence else self.places:
            self.missing.add(Obligation(at, place))

    def _arrive(self, at: int, place: int) -> None:
        self._visits[place] += 1
        if not self.in_sequence:
            self.missing.meet(at, self.places[place])
        elif self.round.arrive(place):
            self._rounds += 1
            self.round.begin()
            self.missing.meet(at, self.places[0])
            self.missing.add(Obligation(at, self.places[0]))

    def _leave(self, at: int, place: int) -> None:
        if not self.in_sequence:
            self.missing.add(Obligation(at, self.places[place]))

    def _expire(self, at: int, obligation: Obligation[str]) -> None:
        place = self.places[self.round.next] if self.in_sequence else obligation.key
        every = f"{self.part.every:g} s"
        text = f"{self.subject} did not reach {place} for {every}"
        self.violate(at, self.subject, f"{place} not every {every}", text)
        self.missing.add(Obligation(at, obligation.key))

    def _unless_violated(self) -> Verdict:
        """Return whether all rounds were in time; the robustness is the least share of the time limit that was left."""
        rounds = self._rounds if self.in_sequence else min(self._visits)
        if not rounds:
            return self._is("undecided", 0.0, f"{self.subject} had not finished its first round by the end")
        text = f"{rounds} rounds of {self.subject}, the longest of {self.missing.seconds:.1f} s"
        return self._is("holds", self.missing.least, text)
