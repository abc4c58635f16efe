"""The guide of a search: it keeps schedules that have exercised something new, and mutates them.

This is how coverage-guided fuzzers work: a schedule is kept if its run has a feature that no earlier run had, or brings
a property nearer to its violation. Kept schedules with rare features are chosen more often. For the reason, see Böhme,
Pham and Roychoudhury, "Coverage-based Greybox Fuzzing as Markov Chain", CCS 2016.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    import random

    from hmrsim.fault_search.candidates import Candidates
    from hmrsim.fault_search.run import Outcome
    from hmrsim.fault_search.schedule import Injection, Moment, Schedule, What

_NEARER: Final = 0.95
"""A schedule is kept if its robustness is less than this share of the lowest one so far."""
_MAX_KEPT: Final = 2_000
_RECOVERY: Final = 4.0
"""The weight of a run in which the controller did something that it does not do without faults."""
_MAX_RARE: Final = 24
"""The number of a schedule's features that count for its weight, the rarest first."""


@dataclass
class Kept:
    """A schedule that has exercised something new.

    Attributes:
        fresh: The moments of its run that the run without faults does not have.
        features: The features that no earlier run had.
        chosen: How often it was chosen to be mutated.
    """

    schedule: Schedule
    moments: Sequence[Moment]
    fresh: Sequence[Moment]
    features: tuple[str, ...]
    chosen: int = 0


class Guide:
    """Records the features of runs, and chooses schedules to mutate; *nominal* has the moments without faults.

    Attributes:
        kept: The schedules that have exercised something new, the oldest first.
        features: The number of runs with each feature.
    """

    def __init__(self, nominal: Sequence[Moment]) -> None:
        self.kept: list[Kept] = []
        self.features: Counter[str] = Counter()
        self._least: dict[str, float] = {}
        self._energies: list[float] = []
        self._nominal = dict.fromkeys(moment.what for moment in nominal)
        # The moments of runs by schedule, and those of all runs.
        self._happened: dict[frozenset[Injection], frozenset[What]] = {}
        self._known: dict[What, None] = {}

    def note(self, schedule: Schedule, outcome: Outcome) -> bool:
        """Record the features of a run; return whether it exercised something new."""
        new = tuple(feature for feature in outcome.features if feature not in self.features)
        self.features.update(outcome.features)
        self._energies.clear()
        nearer = self._nearer(outcome)
        if (new or nearer) and not outcome.failure and len(self.kept) < _MAX_KEPT:
            self.kept.append(Kept(schedule, outcome.moments, self.fresh(outcome), new))
            happened = [moment.what for moment in outcome.moments]
            self._happened[frozenset(schedule)] = frozenset(happened)
            self._known |= dict.fromkeys(happened)
        return bool(new or nearer)

    def can_begin(self, schedule: Schedule) -> bool:
        """Return False if an injection of a schedule is known to have no effect, since its moment does not occur."""
        begun: list[Injection] = []
        waiting = [*schedule]
        come = [injection for injection in waiting if injection.awaited not in self._known]
        while waiting:
            begun += come
            waiting = [injection for injection in waiting if injection not in come]
            happened = self._happened.get(frozenset(begun))
            if happened is None:
                return True
            come = [injection for injection in waiting if injection.awaited in happened]
            if waiting and not come:
                return False
        return True

    def fresh(self, outcome: Outcome) -> list[Moment]:
        """Return the moments of a run that the run without faults does not have."""
        return [moment for moment in outcome.moments if moment.what not in self._nominal]

    def _nearer(self, outcome: Outcome) -> bool:
        """Return whether a property was nearer to its violation than in all earlier runs."""
        found = False
        for verdict in outcome.verdicts:
            robustness = verdict.robustness
            if not math.isfinite(robustness):
                continue
            least = self._least.get(verdict.property, math.inf)
            if robustness < least:
                found = found or robustness < least * _NEARER
                self._least[verdict.property] = robustness
        return found

    def choose(self, rng: random.Random) -> Kept | None:
        """Return a schedule to mutate; None if there is none."""
        if not self.kept:
            return None
        # Between two runs, only the energy of the chosen schedule changes.
        self._energies = self._energies or [self._energy(each) for each in self.kept]
        number = rng.choices(range(len(self.kept)), self._energies)[0]
        kept = self.kept[number]
        kept.chosen += 1
        self._energies[number] = self._energy(kept)
        return kept

    def _energy(self, kept: Kept) -> float:
        rare = sorted(map(self.features.__getitem__, kept.features))[:_MAX_RARE]
        novelty = 0.1 + sum([1.0 / count for count in rare])
        return novelty * (_RECOVERY if kept.fresh else 1.0) / (1.0 + kept.chosen)


_TRIES: Final = 8
_FRESH: Final = 0.8
"""The probability that an injection begins at a moment that the run without faults does not have."""
_FACTORS: Final = (0.25, 0.5, 2.0, 4.0)


class Mutator:
    """Mutates schedules by adding, removing and shifting injections, which last for *durations* in seconds."""

    def __init__(self, candidates: Candidates, at_most: int, durations: Sequence[float]) -> None:
        self._candidates, self._at_most, self._durations = candidates, at_most, durations
        self._ways: tuple[tuple[float, Callable[[Kept, Kept, random.Random], Schedule | None]], ...] = (
            (0.65, self._more),
            (0.1, self._both),
            (0.1, self._instead),
            (0.08, self._elsewhen),
            (0.07, self._longer),
        )

    def changed(self, kept: Kept, other: Kept, rng: random.Random) -> Schedule | None:
        """Return a mutation of a kept schedule, perhaps with parts of *other*, which is another kept schedule."""
        for _ in range(_TRIES):
            way = rng.choices([way for _, way in self._ways], [weight for weight, _ in self._ways])[0]
            schedule = way(kept, other, rng)
            if schedule and schedule != kept.schedule and len(schedule) <= self._at_most:
                return schedule
        return None

    def fresh(self, kept: Kept, rng: random.Random) -> Injection | None:
        """Return an injection at a moment of a run, preferably one that the run without faults does not have."""
        moments = kept.fresh if kept.fresh and rng.random() < _FRESH else kept.moments
        return self._candidates.any(moments, rng)

    def _more(self, kept: Kept, _other: Kept, rng: random.Random) -> Schedule | None:
        injection = self.fresh(kept, rng)
        return without_twins((*kept.schedule, injection)) if injection else None

    def _both(self, kept: Kept, other: Kept, _rng: random.Random) -> Schedule:
        return without_twins((*kept.schedule, *other.schedule))

    def _instead(self, kept: Kept, _other: Kept, rng: random.Random) -> Schedule | None:
        injection = self.fresh(kept, rng)
        if injection is None or not kept.schedule:
            return None
        number = rng.randrange(len(kept.schedule))
        return without_twins((*kept.schedule[:number], injection, *kept.schedule[number + 1 :]))

    def _elsewhen(self, kept: Kept, _other: Kept, rng: random.Random) -> Schedule | None:
        anchored = [i for i, injection in enumerate(kept.schedule) if injection.anchor]
        if not anchored or not kept.moments:
            return None
        number = rng.choice(anchored)
        injection = kept.schedule[number]
        robot = injection.spec.get("robot")
        moments = [moment for moment in kept.moments if robot in (None, moment.robot)]
        if not moments:
            return None
        moved = injection.replaced(when=rng.choice(moments).anchor())
        return without_twins((*kept.schedule[:number], moved, *kept.schedule[number + 1 :]))

    def _longer(self, kept: Kept, _other: Kept, rng: random.Random) -> Schedule | None:
        lasting = [i for i, injection in enumerate(kept.schedule) if "duration" in injection.spec]
        if not lasting:
            return None
        number = rng.choice(lasting)
        injection = kept.schedule[number]
        most = max(self._durations) * 2
        seconds = min(most, round(injection.spec["duration"] * rng.choice(_FACTORS), 3))
        return (*kept.schedule[:number], injection.replaced(duration=seconds), *kept.schedule[number + 1 :])


def without_twins(schedule: Schedule) -> Schedule:
    """Return a schedule without duplicates, and with at most one change of each robot or demand.

    A controller may handle a small battery and a low speed of a robot, but not both together.
    """
    found: dict[str, Injection] = {}
    parts: dict[tuple[str, ...], None] = {}
    for injection in schedule:
        changed = [tuple(path.lstrip("~").split(".")[:2]) for path in injection.spec.get("change", ())]
        if not any(part in parts for part in changed):
            found.setdefault(injection.key, injection)
            parts |= dict.fromkeys(changed)
    return tuple(found.values())
