"""The evaluation of cases on an executor; outcomes do not depend on which worker runs which case."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Final, Self

from hmrsim.fault_search.observer import TotalCoverage
from hmrsim.fault_search.run import NOT_RUN, VERDICTS, Outcome, Wanted, run_within, without_run
from hmrsim.fault_search.schedule import Case
from hmrsim.trials.batches import Batches
from hmrsim.trials.guards import ending_of_lost

if TYPE_CHECKING:
    from concurrent.futures import Executor, Future

    from hmrsim.fault_search.check import Check

_PIECES: Final = 4
"""Tasks per worker into which the rest of a batch is divided each time."""
_MAX_PIECE: Final = 16
"""Maximum cases per task."""
_PIECE_SECONDS: Final = 0.25
"""Maximum wall seconds for a task, unless a single run takes longer."""
_ASSUMED_WORKERS: Final = 32
"""The number of workers to assume if it is unknown."""
_MAX_KNOWN: Final = 50_000
"""Maximum remembered outcomes; a case with one is not run again."""


class Evaluator:
    """Runs the cases of a check on an executor and remembers their outcomes; a context manager.

    Args:
        make: Creates an executor; called again when one breaks.
        workers: The number of cases that the executor runs at once; 0 if unknown, as for a cluster.

    Attributes:
        covered: The coverage of the trees in all runs; workers send only coverage that is new to them.
    """

    def __init__(self, check: Check, make: Callable[[], Executor], workers: int) -> None:
        self.runs = 0
        self.covered = TotalCoverage()
        self.workers = workers or _ASSUMED_WORKERS
        self._check = check
        self._batches = Batches(make, self.workers)
        self._known: dict[str, Outcome] = {}
        self._seconds: float | None = None

    def __enter__(self) -> Self:
        """Return the evaluator."""
        return self

    def __exit__(self, *_error: object) -> None:
        """Stop the executor and the cases that it runs."""
        self.stop()

    def take(self, check: Check, nominal: Outcome | None = None) -> None:
        """Run the cases of another check from now on, on the same executor.

        *nominal* is the outcome of its run without faults, if known. It is ignored if a property compares runs with
        that run, which then has to be compared with itself.
        """
        self._check = check
        self._known.clear()
        if nominal is not None and not check.compares:
            self._keep(Case().key, nominal)

    def stop(self) -> None:
        """Stop the executor; the next cases get a new one."""
        self._batches.stop()

    def outcomes(self, cases: Sequence[Case], until: float = math.inf) -> list[Outcome]:
        """Return the outcomes of cases, in order; only of the first ones if time runs out; see `stream`."""
        return [*self.stream(cases, until)]

    def stream(self, cases: Sequence[Case], until: float = math.inf) -> Generator[Outcome, None, None]:
        """Yield the outcomes of cases in order, as soon as each is available; known cases are not run again.

        The stream ends early at the time *until* of the monotonic clock. Close it to start no further case.

        A repeated outcome has no features and moments, except that of the run without a schedule: they take most of the
        memory of an outcome, and a search makes tens of thousands.
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
                    light = replace(outcome, features=(), moments=(), coverage=b"")
                    self._keep(key, outcome if key == Case().key else light)
                yield fresh.get(case.key) or self._known[case.key]

    def rerun(self, case: Case, until: float = math.inf) -> Outcome:
        """Run a case again; return its outcome with trace and story, or with the ending `NOT_RUN` if time runs out."""
        with closing(self._run([case], until, story=True)) as running:
            _, outcome = next(running, ("", None))
        return outcome or Outcome(NOT_RUN)

    def _keep(self, key: str, outcome: Outcome) -> None:
        if len(self._known) >= _MAX_KNOWN:
            del self._known[next(iter(self._known))]
        self._known[key] = outcome

    def _run(
        self, cases: Sequence[Case], until: float, *, story: bool = False
    ) -> Generator[tuple[str, Outcome], None, None]:
        """Yield the key and the outcome of each case, in order; fewer if time runs out."""
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
        """Yield the cases in pieces that take a fraction of a second, so that stopping early loses little work.

        The last ones are small, so that no worker waits long for another one at the end.
        """
        most = max(1, min(_MAX_PIECE, int(_PIECE_SECONDS / self._seconds) if self._seconds else _MAX_PIECE))
        begun = 0
        while begun < len(cases):
            size = min(most, -(-(len(cases) - begun) // (self.workers * _PIECES)))
            yield cases[begun : begun + size]
            begun += size


_STORY: Final = Wanted(trace=True, story=True)


@dataclass(frozen=True)
class Task:
    """Some cases of a check.

    Attributes:
        story: Whether the outcomes include traces and stories.
        seconds: The wall seconds for all of them.
    """

    check: Check
    cases: Sequence[Case]
    story: bool = False
    seconds: float = math.inf


@lru_cache(maxsize=8)
def _warm(check: Check) -> Check:
    """Return the equal check that this process used before, if any, which has its worlds and routes cached."""
    return check


def execute(task: Task) -> list[Outcome]:
    """Return the outcomes of cases, in order; fewer if time runs out."""
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
