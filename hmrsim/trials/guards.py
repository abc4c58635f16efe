"""Guards around a run: limits on time, memory and output, so that it can't harm other runs."""

from __future__ import annotations

import ctypes
import faulthandler
import io
import math
import multiprocessing
import resource
import signal
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext, redirect_stderr, redirect_stdout
from typing import TYPE_CHECKING, Any, Final, Generic, NamedTuple, TypeVar

from hmrsim.errors import HmrsimError
from hmrsim.program.memory import collect_run
from hmrsim.program.users_code import described
from hmrsim.trials.meter import Meter
from hmrsim.trials.trial import DIED, ERROR, HUNG, MEMORY, OUT_OF_MEMORY, TimeLimit

if TYPE_CHECKING:
    from hmrsim.trials.model import Limits

R = TypeVar("R")

_AT_ONCE: Final = 1e-3
"""Wall seconds until an alarm rings that became due during the run."""
_TAIL: Final = 2_000
"""The number of characters of a run's output that are kept."""


class Tail(io.TextIOBase):
    """A text stream that keeps the last characters written to it."""

    def __init__(self) -> None:
        self._pieces: deque[str] = deque()
        self._length = 0

    def write(self, text: str) -> int:
        """Write a text; only its end is kept."""
        self._pieces.append(text[-_TAIL:])
        self._length += len(self._pieces[-1])
        while self._length - len(self._pieces[0]) >= _TAIL:
            self._length -= len(self._pieces.popleft())
        return len(text)

    def writable(self) -> bool:
        """Return True."""
        return True

    @property
    def text(self) -> str:
        """The last characters that were written."""
        return "".join(self._pieces)[-_TAIL:].strip()


def ending_of_lost(limits: Limits, seconds: float) -> tuple[str, str]:
    """Return the ending of a run whose process is gone after some wall seconds, and the cause.

    The process of a run that ignores its limits is ended some time later.
    """
    if seconds >= Meter(limits).patience:
        return HUNG, "it does not end when its time is over, by limits.wall or limits.processor"
    return DIED, "its worker has died, as of a segmentation fault or of too little memory"


class Attempt(NamedTuple, Generic[R]):
    """A run that was made within its limits.

    Attributes:
        output: The last characters that the run printed.
        wall: The wall seconds that it took.
    """

    result: R
    output: str
    wall: float


def attempt(
    limits: Limits, run: Callable[[], R], failed: Callable[[str, str], R], seconds: float = math.inf
) -> Attempt[R]:
    """Make a run, whatever happens in it.

    Args:
        limits: The limits of the run.
        run: Makes the run; returns its result.
        failed: Returns the result of a run that exceeds a limit or raises an error, from its ending and the cause.
        seconds: Wall seconds after which the run ends in any case, since its result would come too late.
    """
    began = time.perf_counter()
    tail = Tail()
    try:
        with guarded(limits, tail, seconds):
            result = run()
    except TimeLimit as limit:
        result = failed(HUNG, str(limit))
    except MemoryError:
        result = failed(MEMORY, OUT_OF_MEMORY)
    except (HmrsimError, ValueError) as error:
        result = failed(ERROR, str(error))
    except Exception as error:  # noqa: BLE001 - a bug of ours must not end the other runs
        result = failed(ERROR, described(error))
    collect_run()
    return Attempt(result, tail.text, time.perf_counter() - began)


@contextmanager
def guarded(limits: Limits, tail: Tail, seconds: float = math.inf) -> Iterator[None]:
    """Keep a run within its limits, and its output in *tail*.

    When one of its times is over, `TimeLimit` is raised in it. If it ignores that, its process is ended.
    """
    meter = Meter(limits, seconds)
    in_time = _alarm if threading.current_thread() is threading.main_thread() else _watcher
    in_memory = nullcontext() if limits.memory is None else _in_memory(limits.memory)
    _end_process_after(meter)
    with redirect_stdout(tail), redirect_stderr(tail), in_time(meter):
        try:
            with in_memory:
                yield
        finally:
            if _ends_process():
                faulthandler.cancel_dump_traceback_later()


@contextmanager
def _alarm(meter: Meter) -> Iterator[None]:
    """Check a run of the main thread with a signal."""

    def ring(_number: int, _frame: Any) -> None:
        if meter.look():
            raise TimeLimit(meter.why)
        _end_process_after(meter)
        signal.setitimer(signal.ITIMER_REAL, meter.left)

    before = signal.signal(signal.SIGALRM, ring)
    began = time.monotonic()
    left, interval = signal.setitimer(signal.ITIMER_REAL, meter.left)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
        if left:
            # An alarm that was set before the run, such as that of a test.
            signal.setitimer(signal.ITIMER_REAL, max(left - (time.monotonic() - began), _AT_ONCE), interval)


@contextmanager
def _watcher(meter: Meter) -> Iterator[None]:
    """Check a run outside the main thread with a watcher thread, as on Dask workers."""
    runs, over = ctypes.c_ulong(threading.get_ident()), threading.Event()

    def watch() -> None:
        while not over.wait(meter.left):
            if meter.look():
                ctypes.pythonapi.PyThreadState_SetAsyncExc(runs, ctypes.py_object(TimeLimit))
                return
            _end_process_after(meter)

    watcher = threading.Thread(target=watch, name="hmrsim-limits", daemon=True)
    watcher.start()
    try:
        yield
    finally:
        over.set()
        watcher.join()


def _end_process_after(meter: Meter) -> None:
    """End this process if the run ignores its time limit, or blocks the check."""
    if _ends_process():
        faulthandler.dump_traceback_later(meter.patience, exit=True, file=2)


def _ends_process() -> bool:
    """Return whether this is a worker, which may end when a run hangs."""
    return multiprocessing.parent_process() is not None


@contextmanager
def _in_memory(most: int) -> Iterator[None]:
    """Limit the address space of this process to its present size plus a number of bytes."""
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    with open("/proc/self/statm", encoding="ascii") as file:  # noqa: PTH123 - read for each run
        pages = int(file.read().split()[0])
    limit = pages * resource.getpagesize() + most
    resource.setrlimit(resource.RLIMIT_AS, (limit if hard == resource.RLIM_INFINITY else min(limit, hard), hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))
