"""Search for schedules that break a controller.

The search begins with earlier failures and the run without faults. Then it tries one injection of each kind, so that a
few runs cover all kinds: a fault of a door, lane, dock or lift, and a low battery, from the start. After that it tries
each single injection at each moment, alternating with schedules that the guide proposes: pairs and their mutations. The
schedules depend only on the seed and on earlier outcomes, because the batches have the same size on every executor.
"""

from __future__ import annotations

import math
import random
from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

from hmrsim.fault_search.guide import Guide, Kept, Mutator, without_twins
from hmrsim.fault_search.schedule import Case, Injection
from hmrsim.fault_search.summary import Tried

if TYPE_CHECKING:
    from hmrsim.fault_search.candidates import Candidates, Single
    from hmrsim.fault_search.check import Check
    from hmrsim.fault_search.evaluator import Evaluator
    from hmrsim.fault_search.run import Failure, Outcome
    from hmrsim.fault_search.schedule import Moment, Schedule

Strategy = Literal["guided", "random"]

BATCH: Final = 32
"""The number of cases in a batch."""
_PROBES: Final = 12
"""The number of probes in a batch, while there are any."""
_SINGLES: Final = 8
"""The number of single injections in a batch."""
_TRIES: Final = 20
_LOW: Final = "battery_drop"
"""The fault with which a robot begins with a low battery."""
_RESTART: Final = 0.1
"""The probability of a random schedule instead of a mutation."""


@dataclass(frozen=True)
class Found:
    """A failure, and the first case that has caused it.

    Attributes:
        run: The number of the run, from 1.
    """

    failure: Failure
    case: Case
    outcome: Outcome
    run: int


class Search:
    """Searches for failures, batch by batch.

    Args:
        nominal: The outcome of the run without faults.
        strategy: ``guided``, or ``random`` for comparison.

    Attributes:
        guide: The features of all runs.
        found: The first case of each failure.
        seen_failures: The number of runs with each failure as their first.
    """

    def __init__(
        self,
        check: Check,
        evaluator: Evaluator,
        candidates: Candidates,
        nominal: Outcome,
        strategy: Strategy = "guided",
    ) -> None:
        space = check.file.space
        self.tried = Tried()
        self.guide = Guide(nominal.moments)
        self.found: dict[Failure, Found] = {}
        self.seen_failures: Counter[Failure] = Counter()
        self._evaluator, self._candidates, self._nominal, self._strategy = evaluator, candidates, nominal, strategy
        self._at_most = space.at_most
        self._probes = Probes(candidates, space.at_most)
        self._mutator = Mutator(candidates, space.at_most, space.durations)
        self._rng = random.Random(f"{check.file.seed}/search")
        self._seen: dict[str, None] = {}
        self._known: list[Schedule] = []
        self._single_injections = candidates.singles(nominal.moments, self._rng)
        self._turns = ((injection,) for injection in _one_of_each_kind(self._single_injections.in_order))
        self._singles = ((single.injection,) for single in self._single_injections.in_order)
        self._dropped: dict[str, None] = {}
        self.tried.singles = self.tried.singles_left = len(self._single_injections)
        self._base = Kept((), nominal.moments, nominal.moments, ())

    def next(self, most: int, until: float = math.inf, *, one: bool = False) -> list[Found] | None:
        """Run the next batch; return new failures, or None if there is nothing left to try.

        It stops after *most* runs, at *until* by the monotonic clock, or with *one* at the first failure.
        """
        cases = [Case(schedule) for schedule in self._batch(min(BATCH, most))]
        return self.run(cases, until, one=one) if cases else None

    def pass_over(self, schedule: Schedule) -> None:
        """Stop proposing schedules that contain a failing one."""
        if schedule:
            self._known.append(schedule)

    def run(self, cases: Sequence[Case], until: float = math.inf, *, one: bool = False) -> list[Found]:
        """Run given cases, such as earlier failures; return new failures, as `next` does."""
        new: list[Found] = []
        with closing(self._evaluator.stream(cases, until)) as outcomes:
            for case, outcome in zip(cases, outcomes, strict=False):
                self._count(case, outcome)
                self._note(case.schedule, outcome)
                for failure in outcome.failures[:1]:
                    self.seen_failures[failure] += 1
                    if failure not in self.found:
                        self.found[failure] = Found(failure, case, outcome, self.tried.runs)
                        new.append(self.found[failure])
                if one and new:
                    break
        return new

    def _note(self, schedule: Schedule, outcome: Outcome) -> None:
        """Record a run for further candidates, mutations and probes."""
        self._candidates.note(outcome.moments)
        if self.guide.note(schedule, outcome) and not outcome.failure:
            self._probes.add(schedule, outcome, self.guide.fresh(outcome) if schedule else outcome.moments)

    def _count(self, case: Case, outcome: Outcome) -> None:
        tried = self.tried
        tried.runs += 1
        tried.failed += outcome.failure is not None
        tried.endings[outcome.ending] += 1
        if len(case.schedule) == 1:
            self._drop(case.schedule[0])
        if case.schedule and all(injection.transient for injection in case.schedule):
            tried.transient += 1
            if outcome.ending == "failed":
                tried.gave_up += 1
                tried.gave_up_first = tried.gave_up_first or case.schedule
        for number, injection in enumerate(case.schedule):
            tried.kinds[injection.kind] += 1
            tried.begun[injection.kind] += number >= len(outcome.began) or outcome.began[number] is not None
        tried.exercised.update(each.property for each in outcome.verdicts if each.state != "never_exercised")

    def _batch(self, size: int) -> list[Schedule]:
        if self._strategy == "random":
            return [*self._fresh(self._random, size)]
        found = [*self._new(self._turns, size)]
        found += self._new(iter(self._probes.next, None), min(_PROBES, size - len(found)))
        found += self._new(self._singles, min(_SINGLES, size - len(found)))
        return [*found, *self._fresh(self._guided, size - len(found))]

    def _new(self, schedules: Iterator[Schedule], count: int) -> Iterator[Schedule]:
        """Yield the next schedules that were not tried, at most *count*."""
        while count and (schedule := next(schedules, None)) is not None:
            if self._is_new(schedule):
                yield schedule
                count -= 1
            elif schedules is self._singles and self._passed_over(schedule):
                self._drop(schedule[0])

    def _drop(self, injection: Injection) -> None:
        """Remove a single injection from those left to try."""
        if injection in self._single_injections:
            self._dropped[injection.key] = None
            self.tried.singles_left = self.tried.singles - len(self._dropped)

    def _fresh(self, make: Callable[[], Schedule | None], count: int) -> Iterator[Schedule]:
        """Yield *count* schedules that were not tried; fewer if none is found."""
        for _ in range(count):
            for _ in range(_TRIES):
                schedule = make()
                if schedule and self._is_new(schedule):
                    yield schedule
                    break

    def _guided(self) -> Schedule | None:
        kept = None if self._rng.random() < _RESTART else self.guide.choose(self._rng)
        other = self.guide.choose(self._rng)
        if kept is None or other is None:
            return self._random()
        return self._mutator.changed(kept, other, self._rng)

    def _random(self) -> Schedule:
        """Return injections at random moments of the run without faults."""
        count = self._rng.randint(1, self._at_most)
        injections: list[Injection] = []
        for _ in range(count):
            injection = self._mutator.fresh(self._base, self._rng)
            if injection is not None:
                injections.append(injection)
        return without_twins(tuple(injections))

    def _is_new(self, schedule: Schedule) -> bool:
        case = Case(schedule)
        if case.key in self._seen:
            return False
        self._seen[case.key] = None
        return self.guide.can_begin(schedule) and not self._passed_over(schedule)

    def _passed_over(self, schedule: Schedule) -> bool:
        """Return whether a schedule contains one that is known to fail."""
        injections = frozenset(schedule)
        return any(injections.issuperset(known) for known in self._known)


def _one_of_each_kind(singles: Iterable[Single]) -> list[Injection]:
    """Return the first injection of each kind, or one from the start, which may find more.

    A controller may look at a door only when it starts, and a robot may begin its work with a low battery.
    """
    firsts: dict[str, Single] = {}
    for single in singles:
        injection = single.candidate.injection
        known = firsts.setdefault(injection.kind, single)
        if single.at_start and not known.at_start and (injection.kind == _LOW or not injection.spec.get("robot")):
            firsts[injection.kind] = single
    return [single.injection for single in firsts.values()]


_DOWN: Final = 5.0
"""The duration in seconds of a breakdown that makes a goal fail."""


class Probes:
    """Schedules in which one more goal fails than in an earlier run; each situation is probed once."""

    def __init__(self, candidates: Candidates, at_most: int) -> None:
        self._candidates, self._at_most = candidates, at_most
        self._waiting: deque[Schedule] = deque()
        self._known: dict[tuple[object, ...], None] = {}

    def add(self, schedule: Schedule, outcome: Outcome, moments: Sequence[Moment]) -> None:
        """Add probes of a run, in each of which a goal fails at one of the *moments*."""
        if len(schedule) >= self._at_most:
            return
        for moment in moments:
            if moment.goal != "executing":
                continue
            own = tuple(feature for feature in outcome.features if feature.startswith(f"{moment.robot}/"))
            for injection in self._failing(moment):
                key = (injection.key, own)
                if key not in self._known:
                    self._known[key] = None
                    self._waiting.append((*schedule, injection))

    def next(self) -> Schedule | None:
        """Return the next probe; None if there is none."""
        return self._waiting.popleft() if self._waiting else None

    def _failing(self, moment: Moment) -> Iterator[Injection]:
        """Yield the allowed injections that make a goal fail."""
        subject = {"robot": moment.robot, "when": moment.anchor()}
        aborted = Injection({"type": "goals_aborted", "action": moment.action, "count": 1, **subject})
        down = Injection({"type": "breakdown", "duration": _DOWN, **subject})
        return (injection for injection in (aborted, down) if self._candidates.allows(injection))
