"""Running many cases on an executor; what comes of them does not depend on which worker runs what."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Final, Self

from hmrsim.fault_search.running.observer import TotalCoverage
from hmrsim.fault_search.running.single import NOT_RUN, VERDICTS, Outcome, Wanted, run_within, without_run
from hmrsim.fault_search.schedule import Case
from hmrsim.trials.batches import Batches
from hmrsim.trials.guards import ending_of_lost

if TYPE_CHECKING:
    from concurrent.futures import Executor, Future

    from hmrsim.fault_search.check import Check

_PIECES: Final = 4
"""Tasks per worker in a batch: several, so that all workers stay busy until its end."""
_MAX_PIECE: Final = 16
_PIECE: Final = 0.25
"""Wall seconds that a task should take at most, unless a single run takes longer."""
_MANY: Final = 32
"""The number of workers to assume if it is unknown."""
_KEPT: Final = 50_000
"""Outcomes that are remembered, so that no case is run twice."""


class Evaluator:
    """Runs the cases of a check on an executor and remembers their outcomes; a context manager.

    Args:
        check: The check.
        make: Creates an executor; called again when one breaks.
        workers: The number of cases that it runs at once; 0 if unknown, as for a cluster.

    Attributes:
        runs: The number of runs.
        covered: The coverage of the trees in all runs; workers send only coverage that is new to them.
    """

    def __init__(self, check: Check, make: Callable[[], Executor], workers: int) -> None:
        self.runs = 0
        self.covered = TotalCoverage()
        self.workers = workers or _MANY
        self._check = check
        self._batches = Batches(make, self.workers)
        self._known: dict[str, Outcome] = {}
        self._seconds: float | None = None

    def __enter__(self) -> Self:
        """Return the evaluator."""
        return self

    def __exit__(self, *_error: object) -> None:
        """End the executor, with what it does."""
        self.stop()

    def take(self, check: Check, nominal: Outcome | None = None) -> None:
        """Run the cases of another check from now on, on the same executor.

        *nominal* is the outcome of its run without faults, if known. If a property compares runs with that one, it
        is made again, to be compared with itself.
        """
        self._check = check
        self._known.clear()
        if nominal is not None and not check.compares:
            self._keep(Case().key, nominal)

    def stop(self) -> None:
        """End the executor; the next cases have a new one."""
        self._batches.stop()

    def outcomes(self, cases: Sequence[Case], until: float = math.inf) -> list[Outcome]:
        """Return what comes of some cases, in order; only of the first ones if time is over before; see `stream`."""
        return [*self.stream(cases, until)]

    def stream(self, cases: Sequence[Case], until: float = math.inf) -> Generator[Outcome, None, None]:
        """Yield the outcomes of cases in order, as soon as each is available; known cases are not run again.

        The stream ends early when time is up. Close it to start no further case.

        Features and moments are included only the first time, except for the run without a schedule: they are most of
        an outcome, and a search runs tens of thousands.

        *until* is the last moment, by the monotonic clock.
        """
        missing = {case.key: case for case in cases if case.key not in self._known}
        fresh: dict[str, Outcome] = {}
        with closing(self._run([*missing.values()], until)) as running:
            for case in cases:
                while case.key not in fresh and case.key not in self._known:
                    ran = next(running, None)
                    if ran is None:
                        return
                    key, outcome = ran
                    fresh[key] = outcome
                    self._keep(key, outcome if key == Case().key else _light(outcome))
                yield fresh.get(case.key) or self._known[case.key]

    def rerun(self, case: Case, until: float = math.inf) -> Outcome:
        """Run a case again; return its outcome with the trace and the events in words.

        Its ending is `NOT_RUN` if there was no time for it.
        """
        with closing(self._run([case], until, story=True)) as running:
            _, outcome = next(running, ("", None))
        return outcome or Outcome(NOT_RUN)

    def _keep(self, key: str, outcome: Outcome) -> None:
        if len(self._known) >= _KEPT:
            del self._known[next(iter(self._known))]
        self._known[key] = outcome

    def _run(
        self, cases: Sequence[Case], until: float, *, story: bool = False
    ) -> Generator[tuple[str, Outcome], None, None]:
        """Yield the key and the outcome of each case, in order; fewer if time is over."""
        pieces, check = self._pieces(cases), self._check

        def submit(executor: Executor, piece: Sequence[Case]) -> Future[list[Outcome]]:
            return executor.submit(execute, Task(check, piece, story, until - time.monotonic()))

        def lost(case: Case, seconds: float) -> Outcome:
            return without_run(check, case, *ending_of_lost(check.file.limits, seconds))

        running = self._batches.results(lambda: next(pieces, ()), submit, lost, in_order=True, until=until)
        with closing(running):
            for piece, outcomes in running:
                self.covered.take(outcome.coverage for outcome in outcomes)
                for case, outcome in zip(piece, outcomes, strict=False):
                    self.runs += 1
                    self._seconds = outcome.wall if self._seconds is None else (7 * self._seconds + outcome.wall) / 8
                    yield case.key, outcome

    def _pieces(self, cases: Sequence[Case]) -> Iterator[Sequence[Case]]:
        """Yield the cases in pieces of a fraction of a second, so that little is in vain when the rest is dropped."""
        size = min(_MAX_PIECE, -(-len(cases) // (self.workers * _PIECES)))
        if self._seconds:
            size = min(size, int(_PIECE / self._seconds))
        size = max(1, size)
        return (cases[i : i + size] for i in range(0, len(cases), size))


def _light(outcome: Outcome) -> Outcome:
    """Return an outcome without what its run has exercised."""
    return replace(outcome, features=(), moments=(), coverage=b"")


_STORY: Final = Wanted(trace=True, story=True)


@dataclass(frozen=True)
class Task:
    """Some cases of a check.

    Attributes:
        check: The check.
        cases: The cases.
        story: Whether their traces and events are wanted.
        seconds: Wall seconds that there are for them.
    """

    check: Check
    cases: Sequence[Case]
    story: bool = False
    seconds: float = math.inf


@lru_cache(maxsize=8)
def _warm(check: Check) -> Check:
    """Return a check that this process has worked at, if it has: with its worlds and routes."""
    return check


def execute(task: Task) -> list[Outcome]:
    """Return the outcomes of some cases, in order; fewer if the time for them is over."""
    check = _warm(task.check)
    until = time.monotonic() + task.seconds
    outcomes: list[Outcome] = []
    for case in task.cases:
        left = until - time.monotonic()
        outcome = run_within(check, case, _STORY if task.story else VERDICTS, left) if left > 0.0 else None
        if outcome is None:
            break
        outcomes.append(outcome)
    return outcomes
