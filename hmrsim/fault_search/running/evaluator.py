"""Running many cases on an executor; what comes of them does not depend on which worker runs what."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from concurrent.futures import BrokenExecutor, Executor, Future
from dataclasses import replace
from typing import TYPE_CHECKING, Final, Self

from hmrsim.experiments.running.executors import stop
from hmrsim.experiments.running.guards import ending_of_lost
from hmrsim.fault_search.running.covered import Covered
from hmrsim.fault_search.running.single import without_run
from hmrsim.fault_search.running.tasks import Task, execute
from hmrsim.fault_search.schedules.case import Case

if TYPE_CHECKING:
    from hmrsim.fault_search.file.check import Check
    from hmrsim.fault_search.running.outcome import Outcome

_PIECES: Final = 4
"""Tasks for each worker, of the cases that are run together: the last ones of a batch keep all workers busy."""
_MAX_PIECE: Final = 16
_KEPT: Final = 50_000
"""Outcomes that are kept, so that no case is run twice."""


class Serial(Executor):
    """An executor that calls in this process, one call after the other."""

    def submit(self, function: Callable[..., object], /, *args: object, **kwargs: object) -> Future[object]:  # type: ignore[override]  # of any result
        """Call a function; return its result."""
        future: Future[object] = Future()
        try:
            future.set_result(function(*args, **kwargs))
        except Exception as error:  # noqa: BLE001 - as an executor does
            future.set_exception(error)
        return future


class Evaluator:
    """Runs cases of a check on an executor, and remembers what came of them; a context manager.

    Args:
        check: The check.
        make: Makes an executor; called again when one has broken.
        workers: How many cases it runs at once.

    Attributes:
        runs: How many runs were made.
        covered: What all of them have ticked of a tree: a worker sends what it has not sent before, and only once.
    """

    def __init__(self, check: Check, make: Callable[[], Executor], workers: int) -> None:
        self.runs = 0
        self.covered = Covered()
        self.workers = max(1, workers)
        self._check, self._make = check, make
        self._executor: Executor | None = None
        self._known: dict[str, Outcome] = {}

    def __enter__(self) -> Self:
        """Return the evaluator."""
        return self

    def __exit__(self, *_error: object) -> None:
        """End the executor, with what it does."""
        self.stop()

    def take(self, check: Check) -> None:
        """Run the cases of another check from now on, on the same executor."""
        self._check = check
        self._known.clear()

    def stop(self) -> None:
        """End the executor; the next cases have a new one."""
        executor, self._executor = self._executor, None
        if executor is not None:
            stop(executor)

    def outcomes(self, cases: Sequence[Case]) -> list[Outcome]:
        """Return what comes of some cases, in order; those that were run before are not run again.

        What a run has exercised is told once, of the run without a schedule each time: it is most of an outcome, and
        a search runs tens of thousands.
        """
        missing = {case.key: case for case in cases if case.key not in self._known}
        fresh = dict(zip(missing, self._run([*missing.values()], story=False), strict=True))
        found = [fresh.get(case.key) or self._known[case.key] for case in cases]
        for key, outcome in fresh.items():
            self._keep(key, outcome if key == Case().key else _light(outcome))
        return found

    def told(self, case: Case) -> Outcome:
        """Return what comes of a case, with its trace and its events in words; it is run for that."""
        return self._run([case], story=True)[0]

    def _keep(self, key: str, outcome: Outcome) -> None:
        if len(self._known) >= _KEPT:
            del self._known[next(iter(self._known))]
        self._known[key] = outcome

    def _run(self, cases: Sequence[Case], *, story: bool) -> list[Outcome]:
        size = max(1, min(_MAX_PIECE, -(-len(cases) // (self.workers * _PIECES))))
        pieces = [cases[i : i + size] for i in range(0, len(cases), size)]
        self.runs += len(cases)
        try:
            outcomes = [outcome for piece in self._together(pieces, story=story) for outcome in piece]
        except BrokenExecutor:
            self.stop()
            outcomes = [self._alone(case, story=story) for case in cases]
        self.covered.take(outcome.coverage for outcome in outcomes)
        return outcomes

    def _together(self, pieces: Sequence[Sequence[Case]], *, story: bool) -> list[list[Outcome]]:
        executor = self._executor = self._executor or self._make()
        futures = [executor.submit(execute, Task(self._check, piece, story)) for piece in pieces]
        return [future.result() for future in futures]

    def _alone(self, case: Case, *, story: bool) -> Outcome:
        """Return what comes of a case that may have broken an executor."""
        begun = time.monotonic()
        try:
            return self._together([[case]], story=story)[0][0]
        except BrokenExecutor:
            self.stop()
            seconds = time.monotonic() - begun
            return without_run(self._check, case, *ending_of_lost(self._check.file.limits.wall, seconds))


def _light(outcome: Outcome) -> Outcome:
    """Return an outcome without what its run has exercised."""
    return replace(outcome, features=(), moments=(), coverage=b"")
