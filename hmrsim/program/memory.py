"""Memory of processes that run for long, or make many objects: Python's garbage collector and the C library's heap."""

from __future__ import annotations

import gc
import os
import sys
import time
from typing import Final

_THRESHOLDS: Final = (50_000, 20, 10)
_OF_TRIALS: Final = (50_000, 10, 5)

_M_ARENA_MAX: Final = -8
_M_MMAP_THRESHOLD: Final = -3
"""Parameters of glibc's ``mallopt``."""
_ARENAS: Final = 2
_MAX_PIECE: Final = 32_768
"""Bytes; Zenoh's buffers of 64 KiB are larger."""
_TRIM_PERIOD: Final = 60.0
"""Wall seconds between two releases of free memory, each of which takes some milliseconds while Python goes on."""


def raise_thresholds() -> None:
    """Collect garbage less often than by default: objects that a command loads stay until it ends."""
    gc.set_threshold(*_THRESHOLDS)


def collect_rarely() -> None:
    """Exclude existing objects from garbage collection, and collect new ones less often.

    A simulation makes few cycles and many objects that live for one lane or goal. With a thousand robots, the defaults
    spend a fifth of the time on traversing them.
    """
    gc.freeze()
    raise_thresholds()


def collect_runs_young() -> None:
    """Collect so rarely that most runs have ended by then; keep settings that are as rare, or off.

    All objects of a run refer to each other, so that only the collector frees them. With Python's defaults they have
    become old by then, and finding them among everything that is loaded took a quarter of the time of a short run.
    """
    if 0 < gc.get_threshold()[0] < _OF_TRIALS[0]:
        gc.set_threshold(*_OF_TRIALS)


def collect_run() -> None:
    """Collect the objects of a run that has just ended, in a process that makes many runs.

    Its objects are still in the processor's caches: each takes a quarter of the time that it takes after forty runs.
    """
    gc.collect(0)


class Heap:
    """The C library's heap of this process, with few arenas for all threads; create it before any thread starts.

    By default, glibc gives each of Zenoh's threads its own arena. One thread allocates memory that another frees, and
    free pieces accumulate in all arenas: the process grows for hours with nothing in it. The same happens where small
    long-lived pieces end up between the large buffers of short-lived sessions, so those get their own pages, which are
    returned at once. Environment variables documented by glibc take precedence. Other C libraries are left alone.
    """

    def __init__(self) -> None:
        # Slow to load, and only needed by processes that serve.
        import ctypes  # noqa: PLC0415

        library = ctypes.CDLL(None) if sys.platform == "linux" else None
        self._trim = getattr(library, "malloc_trim", None)
        self._due = time.monotonic() + _TRIM_PERIOD
        mallopt = getattr(library, "mallopt", None)
        if mallopt is not None and "MALLOC_ARENA_MAX" not in os.environ:
            mallopt(_M_ARENA_MAX, _ARENAS)
        if mallopt is not None and "MALLOC_MMAP_THRESHOLD_" not in os.environ:
            mallopt(_M_MMAP_THRESHOLD, _MAX_PIECE)

    def trim(self) -> None:
        """Return free memory to the system, at most once a minute; call it periodically."""
        now = time.monotonic()
        if self._trim is not None and now >= self._due:
            self._due = now + _TRIM_PERIOD
            self._trim(0)
