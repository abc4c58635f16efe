"""What executes runs: any `concurrent.futures.Executor`."""

from __future__ import annotations

import ctypes
import importlib
import multiprocessing
import os
import signal
import sys
from collections.abc import Callable
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from contextlib import suppress
from typing import TYPE_CHECKING, Any, Final

from hmrsim.errors import ExperimentError, Problem
from hmrsim.program.memory import collect_rarely

if TYPE_CHECKING:
    from types import ModuleType

POOL, DASK = "pool", "dask"

_PR_SET_PDEATHSIG: Final = 1
"""Of Linux's prctl: a signal when the process that has started this one dies, however it does."""


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


def factory_of(text: str, jobs: int | None) -> tuple[Callable[[], Executor], int]:
    """Return what makes an executor, and how many runs it executes at once.

    Args:
        text: ``pool`` or ``pool:N``, ``dask``, ``dask://HOST:PORT`` or ``MODULE:FACTORY``.
        jobs: How many processes; None for one a processor.

    Raises:
        ExperimentError: There is no such executor.
    """
    count = jobs or _processors()
    name, colon, rest = text.partition(":")
    if name == POOL:
        if colon and not (rest.isdecimal() and int(rest) > 0):
            raise _error(text, f"expected a number of processes after pool:, got {rest!r}")
        workers = int(rest) if colon else count
        return lambda: _pool(workers), workers
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
    """End an executor with what it does."""
    for process in [*(getattr(executor, "_processes", None) or {}).values()]:
        process.terminate()
    executor.shutdown(wait=True, cancel_futures=True)


def prepare_worker() -> None:
    """Make a process of a pool ready: it says nothing, leaves Ctrl-C to its parent, and ends with that."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    parent = multiprocessing.parent_process()
    if parent is not None and parent.pid != os.getppid():
        os._exit(1)  # it has died before
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for stream in (1, 2):
        os.dup2(nowhere, stream)
    collect_rarely()


def _processors() -> int:
    """Return how many this process may use; only Linux tells which those are."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _pool(workers: int) -> Executor:
    return ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn"), initializer=prepare_worker)


def _dask(distributed: Any, address: str, workers: int) -> Executor:
    """Return the executor of a Dask cluster; one of this machine is made where no address is given."""
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
    """An executor that closes its cluster with it."""

    def __init__(self, executor: Executor, client: Any) -> None:
        self._executor, self._client = executor, client

    def submit(self, function: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Any:
        """Submit a call."""
        return self._executor.submit(function, *args, **kwargs)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:  # noqa: FBT001, FBT002 - as of Executor
        """End it, and the cluster if it was made for it."""
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
