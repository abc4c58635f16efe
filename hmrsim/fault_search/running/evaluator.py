"""Running many cases on an executor; what comes of them does not depend on which worker runs what."""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import BrokenExecutor, Executor, Future
from contextlib import closing
from dataclasses import replace
from typing import TYPE_CHECKING, Final, NamedTuple, Self

from hmrsim.fault_search.running.covered import Covered
from hmrsim.fault_search.running.outcome import NOT_RUN, Outcome
from hmrsim.fault_search.running.single import without_run
from hmrsim.fault_search.running.tasks import Task, execute
from hmrsim.fault_search.schedules.case import Case
from hmrsim.trials.executors import stop
from hmrsim.trials.guards import ending_of_lost

if TYPE_CHECKING:
    from hmrsim.fault_search.file.check import Check

_PIECES: Final = 4
"""Tasks for each worker, of the cases that are run together: the last ones of a batch keep all workers busy."""
_MAX_PIECE: Final = 16
_PIECE: Final = 0.25
"""Wall seconds that a task is to take at most, unless one run takes longer."""
_MANY: Final = 32
"""How many workers there may be where it is not known."""
_AHEAD: Final = 2
"""Tasks for each worker that are submitted at once."""
_GRACE: Final = 1.0
"""Wall seconds that a run has to end when its time is over, until its process is ended."""
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
        workers: How many cases it runs at once; 0 if that is not known, as of a cluster.

    Attributes:
        runs: How many runs were made.
        covered: What all of them have ticked of a tree: a worker sends what it has not sent before, and only once.
    """

    def __init__(self, check: Check, make: Callable[[], Executor], workers: int) -> None:
        self.runs = 0
        self.covered = Covered()
        self.workers = workers or _MANY
        self._check, self._make = check, make
        self._executor: Executor | None = None
        self._known: dict[str, Outcome] = {}
        self._seconds: float | None = None

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

    def outcomes(self, cases: Sequence[Case], until: float = math.inf) -> list[Outcome]:
        """Return what comes of some cases, in order; only of the first ones if time is over before; see `stream`."""
        return [*self.stream(cases, until)]

    def stream(self, cases: Sequence[Case], until: float = math.inf) -> Generator[Outcome, None, None]:
        """Yield what comes of some cases, in order and as soon as it is known; those known before are not run again.

        It ends early when time is over. Who has seen enough closes it: then no further case is begun.

        What a run has exercised is told once, of the run without a schedule each time: it is most of an outcome, and
        a search runs tens of thousands.

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

    def told(self, case: Case, until: float = math.inf) -> Outcome:
        """Return what comes of a case, with its trace and its events in words; it is run for that.

        Its ending is `NOT_RUN` if there was no time for that.
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
        """Yield the key and the outcome of each case, in order; fewer if time is over.

        Only as many pieces are submitted as keep the workers busy, so that the others can be dropped.
        """
        pieces = deque(self._pieces(cases))
        begun: deque[_Begun] = deque()
        try:
            while pieces or begun:
                try:
                    while pieces and len(begun) < _AHEAD * self.workers:
                        begun.append(_Begun(pieces[0], self._submit(pieces[0], until, story=story)))
                        pieces.popleft()
                    outcomes = _awaited(begun[0].future, until)
                    piece = begun.popleft().piece
                except BrokenExecutor:
                    self.stop()
                    # One of them has broken it: the first one is run alone, and the others once more.
                    pieces.extendleft(each.piece for each in reversed(begun))
                    begun.clear()
                    piece = pieces.popleft()
                    outcomes = [each for case in piece for each in self._alone(case, until, story=story)]
                if outcomes is None:
                    # What does not mind that its time is over ends with its process.
                    self.stop()
                    return
                self.covered.take(outcome.coverage for outcome in outcomes)
                for case, outcome in zip(piece, outcomes, strict=False):
                    self.runs += 1
                    self._seconds = outcome.wall if self._seconds is None else (7 * self._seconds + outcome.wall) / 8
                    yield case.key, outcome
                if len(outcomes) < len(piece):
                    return
        finally:
            for each in begun:
                each.future.cancel()

    def _pieces(self, cases: Sequence[Case]) -> Iterator[Sequence[Case]]:
        """Yield the cases in pieces of a fraction of a second, so that little is in vain when the rest is dropped."""
        size = min(_MAX_PIECE, -(-len(cases) // (self.workers * _PIECES)))
        if self._seconds:
            size = min(size, int(_PIECE / self._seconds))
        size = max(1, size)
        return (cases[i : i + size] for i in range(0, len(cases), size))

    def _submit(self, piece: Sequence[Case], until: float, *, story: bool) -> Future[list[Outcome]]:
        executor = self._executor = self._executor or self._make()
        return executor.submit(execute, Task(self._check, piece, story, until - time.monotonic()))

    def _alone(self, case: Case, until: float, *, story: bool) -> list[Outcome]:
        """Return what comes of a case that may have broken an executor; nothing if time is over."""
        begun = time.monotonic()
        try:
            return _awaited(self._submit([case], until, story=story), until) or []
        except BrokenExecutor:
            self.stop()
            seconds = time.monotonic() - begun
            return [without_run(self._check, case, *ending_of_lost(self._check.file.limits, seconds))]


class _Begun(NamedTuple):
    """A piece that an executor has."""

    piece: Sequence[Case]
    future: Future[list[Outcome]]


def _awaited(future: Future[list[Outcome]], until: float) -> list[Outcome] | None:
    """Return the outcomes of a piece; None if it is not done some time after time is over."""
    try:
        return future.result(None if until == math.inf else max(0.0, until - time.monotonic()) + _GRACE)
    except TimeoutError:
        if future.done():
            raise
        return None


def _light(outcome: Outcome) -> Outcome:
    """Return an outcome without what its run has exercised."""
    return replace(outcome, features=(), moments=(), coverage=b"")
