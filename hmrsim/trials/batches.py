"""Batches of trials on an executor, even if single trials break it."""

from __future__ import annotations

import importlib
import math
import multiprocessing
import os
import signal
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Generator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, ProcessPoolExecutor, wait
from contextlib import suppress
from dataclasses import dataclass, field
from multiprocessing import forkserver
from typing import TYPE_CHECKING, Any, Final, Generic, TypeVar

from hmrsim.errors import ExperimentError, HmrsimError, Problem
from hmrsim.program.memory import collect_rarely

if TYPE_CHECKING:
    from types import ModuleType

T = TypeVar("T")
R = TypeVar("R")

_AHEAD: Final = 2
"""Pieces for each worker that are submitted in advance."""
_GRACE: Final = 1.0
"""Wall seconds after its time limit until the process of a piece is ended."""


class Batches:
    """Runs work on an executor, which is created when first needed and again when it breaks.

    Args:
        workers: The number of pieces that it runs at the same time.

    Attributes:
        most: The maximum number of pieces that are submitted at the same time.
    """

    def __init__(self, make: Callable[[], Executor], workers: int) -> None:
        self.most = _AHEAD * workers
        self._make = make
        self._executor: Executor | None = None

    def stop(self) -> None:
        """End the executor and the pieces that it runs; the next work gets a new executor."""
        executor, self._executor = self._executor, None
        if executor is not None:
            stop(executor)

    def close(self) -> None:
        """End the executor after the pieces that it runs."""
        executor, self._executor = self._executor, None
        if executor is not None:
            executor.shutdown(wait=True, cancel_futures=True)

    def results(
        self,
        pieces: Callable[[], Sequence[T]],
        submit: Callable[[Executor, Sequence[T]], Future[list[R]]],
        lost: Callable[[T, float], R],
        *,
        in_order: bool = False,
        until: float = math.inf,
    ) -> Generator[tuple[Sequence[T], list[R]], None, None]:
        """Yield each piece with its results, as soon as they are available.

        When the executor breaks, each task that was running is run again alone, to find the one that breaks it. Close
        the generator to start no further piece.

        Args:
            pieces: Returns the next piece of tasks; an empty one when there is none left.
            submit: Submits a piece; its results are in the order of its tasks, fewer if its time is over.
            lost: Returns the result of a task that broke its executor, from the task and its wall seconds.
            in_order: Whether pieces are yielded in their order.
            until: The last moment, by the monotonic clock; work that goes on after it is ended.

        Raises:
            HmrsimError: A piece raises it.
        """
        return _Work(self, pieces, submit, lost, in_order, until).results()

    @property
    def executor(self) -> Executor:
        """The executor, created when first needed."""
        self._executor = self._executor or self._make()
        return self._executor


@dataclass
class _Work(Generic[T, R]):
    """One call of `Batches.results`, with its arguments and its state.

    Attributes:
        _again: A piece that had not begun when the executor broke.
        _suspects: Tasks that may have broken it.
        _broken: Tasks that were running when the executor broke; None while it works.
    """

    _batches: Batches
    _pieces: Callable[[], Sequence[T]]
    _submit: Callable[[Executor, Sequence[T]], Future[list[R]]]
    _lost: Callable[[T, float], R]
    _in_order: bool
    _until: float
    _begun: dict[Future[list[R]], Sequence[T]] = field(default_factory=dict)
    _again: Sequence[T] = ()
    _suspects: deque[T] = field(default_factory=deque)
    _alone: bool = False
    _since: float = 0.0
    _broken: list[T] | None = None

    def results(self) -> Generator[tuple[Sequence[T], list[R]], None, None]:
        try:
            while self._begin():
                done = [] if self._broken is not None else self._wait()
                if done is None:
                    # A piece that ignores its time limit ends with its process.
                    self._batches.stop()
                    return
                for future in done:
                    piece = self._begun.pop(future)
                    if not self._breaks(future, piece):
                        yield piece, future.result()
                        if len(future.result()) < len(piece):
                            return
                if self._broken is not None:
                    yield from self._after_break(self._broken)
        finally:
            for future in self._begun:
                future.cancel()

    def _begin(self) -> bool:
        """Submit pieces up to the maximum; return whether there is anything to wait for."""
        self._alone, self._since = bool(self._suspects), time.monotonic()
        most = 1 if self._alone else self._batches.most
        while len(self._begun) < most and (piece := self._next()):
            try:
                self._begun[self._submit(self._batches.executor, piece)] = piece
            except BrokenExecutor:
                # One of the pieces that were submitted before broke it, if there are any.
                self._again, self._broken = (piece, []) if self._begun else ((), [*piece])
                break
        return bool(self._begun) or self._broken is not None

    def _next(self) -> Sequence[T]:
        if self._suspects:
            return [self._suspects.popleft()]
        again, self._again = self._again, ()
        return again or self._pieces()

    def _wait(self) -> list[Future[list[R]]] | None:
        """Wait for any piece, or for the first one; return those that are done, or None if time is over."""
        timeout = None if self._until == math.inf else max(0.0, self._until - time.monotonic()) + _GRACE
        awaited = [next(iter(self._begun))] if self._in_order else [*self._begun]
        done = wait(awaited, timeout, return_when=FIRST_COMPLETED).done
        return [future for future in awaited if future in done] or None

    def _breaks(self, future: Future[list[R]], piece: Sequence[T]) -> bool:
        """Return whether the executor broke while it ran a piece, and note the tasks of the piece."""
        error = future.exception()
        if isinstance(error, HmrsimError):
            raise error
        if error is not None:
            self._broken = [*(self._broken or ()), *piece]
        return error is not None

    def _after_break(self, broken: list[T]) -> Generator[tuple[Sequence[T], list[R]], None, None]:
        """Continue with a new executor; yield the result of a task that broke the old one alone."""
        self._batches.stop()
        broken += [task for piece in self._begun.values() for task in piece]
        self._begun.clear()
        self._broken = None
        if self._alone:
            seconds = time.monotonic() - self._since
            yield broken, [self._lost(task, seconds) for task in broken]
        else:
            self._suspects.extend(broken)


POOL, DASK = "pool", "dask"

_METHOD: Final = "forkserver" if sys.platform == "linux" else "spawn"
"""How processes of a pool are started; on macOS, libraries of the system do not survive a fork."""


class Serial(Executor):
    """An executor that makes each call at once, in this process."""

    def submit(self, function: Callable[..., object], /, *args: object, **kwargs: object) -> Future[object]:  # type: ignore[override]  # of any result
        """Call a function; return its result."""
        future: Future[object] = Future()
        try:
            future.set_result(function(*args, **kwargs))
        except Exception as error:  # noqa: BLE001 - as an executor does
            future.set_exception(error)
        return future


def factory_of(text: str, jobs: int | None) -> tuple[Callable[[], Executor], int]:
    """Return a function that creates an executor, and the number of runs that it executes at the same time.

    Args:
        text: ``pool`` or ``pool:N``, ``dask``, ``dask://HOST:PORT`` or ``MODULE:FACTORY``.
        jobs: The number of processes; None for one per processor.

    Raises:
        ExperimentError: There is no such executor.
    """
    # The processors that this process may use, which only Linux reports.
    own = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    count = jobs or own
    name, colon, rest = text.partition(":")
    if name == POOL:
        if colon and not (rest.isdecimal() and int(rest) > 0):
            raise _error(text, f"expected a number of processes after pool:, got {rest!r}")
        workers = int(rest) if colon else count
        context = multiprocessing.get_context(_METHOD)
        return lambda: ProcessPoolExecutor(workers, context, prepare_worker, ({**os.environ},)), workers
    if name == DASK:
        distributed = _imported(text, "distributed", "; install hmrsim[cluster]")
        address = f"tcp://{rest.removeprefix('//')}" if rest.startswith("//") else ""
        return lambda: _dask(distributed, address, count), 0 if address else count
    if colon and name and rest.isidentifier():
        factory = getattr(_imported(text, name, ""), rest, None)
        if not callable(factory):
            raise _error(text, f"module {name!r} has no function {rest!r}")
        return factory, count
    raise _error(text, "expected pool, pool:N, dask, dask://HOST:PORT or MODULE:FACTORY")


def stop(executor: Executor) -> None:
    """End an executor and the pieces that it runs."""
    for process in [*(getattr(executor, "_processes", None) or {}).values()]:
        process.terminate()
    executor.shutdown(wait=True, cancel_futures=True)


def load_early(text: str, *modules: str) -> None:
    """Begin to load the modules that a pool's processes need, in the process of which they are copies.

    A command calls this before it loads what it needs itself. *text* is as for `factory_of`; other executors than pools
    load their modules themselves.
    """
    if _METHOD == "forkserver" and text.partition(":")[0] == POOL:
        multiprocessing.get_context(_METHOD).set_forkserver_preload([*modules])
        forkserver.ensure_running()


def prepare_worker(environment: Mapping[str, str]) -> None:
    """Prepare a process of a pool: it prints nothing, leaves Ctrl-C to its parent, and ends with its parent.

    *environment* is that of its parent, since the process of which it is a copy may be older.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    os.environ.clear()
    os.environ.update(environment)
    threading.Thread(target=_end_with_parent, name="hmrsim-parent", daemon=True).start()
    null = os.open(os.devnull, os.O_WRONLY)
    for stream in (1, 2):
        os.dup2(null, stream)
    collect_rarely()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _dask(distributed: Any, address: str, workers: int) -> Executor:
    """Return the executor of a Dask cluster; without an address, of a new cluster on this machine."""
    if address:
        client = distributed.Client(address)
    else:
        cluster = distributed.LocalCluster(
            n_workers=workers, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs="ERROR"
        )
        client = distributed.Client(cluster)
    executor: Executor = client.get_executor(pure=False, retries=0)
    return _Closing(executor, client)


class _Closing(Executor):
    """A Dask executor that closes its cluster when it shuts down."""

    def __init__(self, executor: Executor, client: Any) -> None:
        self._executor, self._client = executor, client

    def submit(self, function: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Any:
        """Submit a call to the cluster and return its future."""
        return self._executor.submit(function, *args, **kwargs)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:  # noqa: FBT001, FBT002 - as of Executor
        """Shut down the executor, and its cluster if it started one."""
        self._executor.shutdown(wait=wait and not cancel_futures)
        with suppress(Exception):
            self._client.close()
        cluster = self._client.cluster
        if cluster is not None:
            with suppress(Exception):
                cluster.close()


def _imported(text: str, module: str, remedy: str) -> ModuleType:
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise _error(text, f"{error}{remedy}") from None


def _error(text: str, message: str) -> ExperimentError:
    return ExperimentError([Problem(f"--executor {text}", "", message)])
