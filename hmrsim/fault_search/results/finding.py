"""A failure that was found and reduced: all that its user is given of it."""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from hmrsim.fault_search.reducing.reducer import Reduced
    from hmrsim.fault_search.running.outcome import Failure, Outcome
    from hmrsim.fault_search.schedules.case import Case
    from hmrsim.fault_search.schedules.thing import Schedule, Thing


@dataclass(frozen=True)
class Finding:
    """A failure that was found.

    Attributes:
        failure: The failure.
        run: The number of the run that has shown it, from 1.
        original: The schedule of that run.
        reduced: The smallest case.
        told: What comes of that, with its trace and its events.
        seconds: Wall seconds after which it was found.
        reducing: Wall seconds that it took to reduce it.
        known: Whether it was found earlier, and is in the folder of the results.
        seen: How many runs of the search have failed like this.
    """

    failure: Failure
    run: int
    original: Schedule
    reduced: Reduced
    told: Outcome
    seconds: float
    reducing: float = 0.0
    known: bool = False
    seen: int = 1

    @property
    def case(self) -> Case:
        """The smallest case."""
        return self.reduced.case

    @property
    def schedule(self) -> Schedule:
        """The smallest schedule."""
        return self.reduced.case.schedule

    @property
    def without(self) -> Sequence[Outcome]:
        """For each thing of the schedule, what comes of the case without it."""
        return self.reduced.without

    @property
    def in_order(self) -> list[tuple[Thing, Outcome]]:
        """The things as they began, each with what comes of the case without it: the first cause comes first."""
        return [(self.schedule[i], self.without[i]) for i in by_begin(self.schedule, self.told)]

    @property
    def text(self) -> str:
        """What was violated, as a sentence."""
        return next(
            (each.text for each in self.told.violations if (each.property, each.reason) == self.failure),
            self.failure.reason,
        )

    @property
    def trace_hash(self) -> str:
        """SHA-256 of the trace."""
        return hashlib.sha256(self.told.trace.encode()).hexdigest() if self.told.trace else ""


def by_begin(schedule: Schedule, outcome: Outcome) -> list[int]:
    """Return the numbers of a schedule's things in the order in which they began in a run; last what never did."""
    began = dict(enumerate(outcome.began))
    return sorted(range(len(schedule)), key=lambda i: math.inf if (at := began.get(i)) is None else at)
