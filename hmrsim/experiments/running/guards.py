"""What keeps a run from harming others: limits of wall time and memory, and of what it prints."""

from __future__ import annotations

import ctypes
import faulthandler
import io
import multiprocessing
import resource
import signal
import threading
import time
from collections import deque
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, redirect_stderr, redirect_stdout
from typing import Any, Final, Protocol

from hmrsim.experiments.judging.labels import DIED, HUNG
from hmrsim.experiments.running.controlling import WallLimit

_PATIENCE: Final = 1.5
"""Times the limit after which the whole process is ended, if the run does not mind that it is over."""
_GRACE: Final = 5.0
"""Wall seconds to add to that."""
_AT_ONCE: Final = 1e-3
"""Wall seconds until an alarm rings that was due meanwhile."""
_TAIL: Final = 2_000
"""Characters of what a run prints that are kept."""


class Limits(Protocol):
    """What a run may take."""

    @property
    def wall(self) -> float:
        """Seconds of the wall's clock."""

    @property
    def memory(self) -> int | None:
        """Bytes that it may take beyond what its worker has."""


class Tail(io.TextIOBase):
    """A text stream that keeps the end of what is written."""

    def __init__(self) -> None:
        self._pieces: deque[str] = deque()
        self._length = 0

    def write(self, text: str) -> int:
        """Take a text."""
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
        """The end of what was written."""
        return "".join(self._pieces)[-_TAIL:].strip()


def ending_of_lost(wall: float, seconds: float) -> tuple[str, str]:
    """Return how a run has ended whose process is gone, and the cause.

    Args:
        wall: The limit of the run, in wall seconds.
        seconds: How long it was under way: a process that does not mind the limit is ended some time after it.
    """
    if seconds >= _longest(wall):
        return HUNG, f"it takes longer than {wall:g} wall seconds, and does not end"
    return DIED, "its worker has died, as of a segmentation fault or of too little memory"


def _longest(wall: float) -> float:
    """Return the wall seconds after which the process of a run is ended."""
    return wall * _PATIENCE + _GRACE


@contextmanager
def guarded(limits: Limits) -> Iterator[Tail]:
    """Keep a run within its limits; yield what gets all that it prints.

    When the time is over, `WallLimit` is raised in it. A run that does not end by that takes its process with it.
    """
    tail = Tail()
    with ExitStack() as stack:
        stack.enter_context(redirect_stdout(tail))
        stack.enter_context(redirect_stderr(tail))
        stack.enter_context(_in_time(limits.wall))
        if limits.memory is not None:
            stack.enter_context(_in_memory(limits.memory))
        yield tail


@contextmanager
def _in_time(seconds: float) -> Iterator[None]:
    why = f"it takes longer than {seconds:g} wall seconds"
    on_main = threading.current_thread() is threading.main_thread()
    if _ends_process():
        faulthandler.dump_traceback_later(_longest(seconds), exit=True, file=2)
    if on_main:

        def ring(_number: int, _frame: Any) -> None:
            raise WallLimit(why)

        before = signal.signal(signal.SIGALRM, ring)
        began = time.monotonic()
        left, interval = signal.setitimer(signal.ITIMER_REAL, seconds)
        try:
            yield
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0.0)
            signal.signal(signal.SIGALRM, before)
            if left:
                # Somebody else's, such as that of a test.
                signal.setitimer(signal.ITIMER_REAL, max(left - (time.monotonic() - began), _AT_ONCE), interval)
            if _ends_process():
                faulthandler.cancel_dump_traceback_later()
        return
    thread = ctypes.c_ulong(threading.get_ident())
    timer = threading.Timer(seconds, ctypes.pythonapi.PyThreadState_SetAsyncExc, (thread, ctypes.py_object(WallLimit)))
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()
        faulthandler.cancel_dump_traceback_later()


def _ends_process() -> bool:
    """Return whether this is a worker, which may end when a run hangs."""
    return multiprocessing.parent_process() is not None


@contextmanager
def _in_memory(most: int) -> Iterator[None]:
    """Let this process have so many bytes more of address space than it has."""
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    with open("/proc/self/statm", encoding="ascii") as file:  # noqa: PTH123 - read for each run
        pages = int(file.read().split()[0])
    limit = pages * resource.getpagesize() + most
    resource.setrlimit(resource.RLIMIT_AS, (limit if hard == resource.RLIM_INFINITY else min(limit, hard), hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))
