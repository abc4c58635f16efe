"""The time that a run uses: wall time, and the processor time of this process and its descendants."""

from __future__ import annotations

import math
import os
import resource
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Final, NamedTuple

if TYPE_CHECKING:
    from hmrsim.trials.model import Limits

_PROCESSES: Final = Path("/proc")
_NANO: Final = 1e-9
_AFTER_NAME: Final = slice(11, 15)
"""The fields of ``/proc/PID/stat`` after the name with user and system time of the process and its ended children."""
_PARENT: Final = 1
"""The index of the parent's id among the fields after the name."""
_MAX_LINE: Final = 128
"""An upper bound of the bytes of ``/proc/PID/task/TID/schedstat``."""

_BETWEEN_LOOKS: Final = 0.02
"""The minimum of wall seconds between two looks."""
_PATIENCE: Final = 0.5
_GRACE: Final = 5.0
"""A run that exceeds its limit has to end within the share `_PATIENCE` of the limit, plus `_GRACE` wall seconds."""


class Usage(NamedTuple):
    """Seconds since the start of this process, summed over its threads and all its descendants.

    Attributes:
        used: Processor time.
        delayed: Time in which they were ready to run while other processes had the processor; 0 except on Linux.
    """

    used: float
    delayed: float

    @classmethod
    def now(cls) -> Usage:
        """Return the usage so far; except on Linux, children count only when they have ended."""
        ended = resource.getrusage(resource.RUSAGE_CHILDREN)
        used = time.process_time() + ended.ru_utime + ended.ru_stime
        delayed = _delayed("self")
        for process, seconds in _descendants():
            used += seconds
            delayed += _delayed(process)
        return cls(used, delayed)


class Meter:
    """Measures the time that a run uses, from the construction of the meter.

    Wall time in which the run is ready to compute while other processes have the processor counts towards no limit.

    Args:
        seconds: Wall seconds after which its time is over in any case.

    Attributes:
        why: The limit that the run exceeds, in words; empty if none.
    """

    def __init__(
        self,
        limits: Limits,
        seconds: float = math.inf,
        clock: Callable[[], float] = time.monotonic,
        usage: Callable[[], Usage] = Usage.now,
    ) -> None:
        self.why = ""
        self._wall, self._seconds = limits.wall, seconds
        self._processor = limits.wall if limits.processor is None else limits.processor
        self._clock, self._usage = clock, usage
        # The clock is read after the usage here, and before it in `look`: time between the readings is not waiting.
        self._at_first = self._before = usage()
        self._began = self._looked = clock()
        # Seconds in which the run computed or was ready to.
        self._busy = 0.0

    @property
    def left(self) -> float:
        """The wall seconds until the run can exceed a limit."""
        used = self._before.used - self._at_first.used
        since = self._looked - self._began
        return max(_BETWEEN_LOOKS, min(self._wall - since + self._busy, self._processor - used, self._seconds - since))

    @property
    def patience(self) -> float:
        """The wall seconds after which a run counts as ignoring its limit."""
        return self.left + _PATIENCE * min(self._wall, self._processor) + _GRACE

    def look(self) -> bool:
        """Measure the time used so far, and return whether the run exceeds a limit."""
        self._looked = self._clock()
        usage, before = self._usage(), self._before
        self._before = usage
        # The delays of a thread or process are lost when it ends.
        self._busy += max(0.0, usage.used - before.used) + max(0.0, usage.delayed - before.delayed)
        since = self._looked - self._began
        if usage.used - self._at_first.used >= self._processor:
            self.why = f"it takes longer than {self._processor:g} s of processor time"
        elif since - self._busy >= self._wall:
            self.why = f"it has waited for {self._wall:g} wall seconds without computing anything"
        elif since >= self._seconds:
            self.why = f"it takes longer than the {self._seconds:.3g} wall seconds that were left for it"
        return bool(self.why)


def _descendants() -> Iterator[tuple[str, float]]:
    """Yield all descendants of this process, each with its processor time."""
    if sys.platform != "linux" or not _has_children():
        return
    children: dict[str, list[tuple[str, float]]] = {}
    tick = 1.0 / os.sysconf("SC_CLK_TCK")
    # /proc/PID/task/TID/children exists for each thread, and may leave out some while others end.
    for path in _PROCESSES.glob("[0-9]*/stat"):
        with suppress(OSError):  # the process has ended
            # The name may have spaces and parentheses.
            fields = path.read_text(encoding="ascii", errors="replace").rpartition(")")[2].split()
            children.setdefault(fields[_PARENT], []).append(
                (path.parent.name, sum(map(int, fields[_AFTER_NAME])) * tick)
            )
    parents = [str(os.getpid())]
    while parents:
        found = children.get(parents.pop(), [])
        yield from found
        parents += [process for process, _ in found]


def _has_children() -> bool:
    """Return whether this process has children, a thousand times faster than by listing all processes."""
    try:
        os.waitid(os.P_ALL, 0, os.WEXITED | os.WNOHANG | os.WNOWAIT)
    except ChildProcessError:
        return False
    return True


def _delayed(process: str) -> float:
    """Return the seconds that the threads of a process waited for a processor."""
    threads = f"{_PROCESSES}/{process}/task"
    try:
        found = os.listdir(threads)  # noqa: PTH208 - a process may have hundreds of threads
    except OSError:  # the process has ended, or the system has no such files
        return 0.0
    return sum(_waited(f"{threads}/{thread}/schedstat") for thread in found) * _NANO


def _waited(path: str) -> int:
    """Return the nanoseconds that a thread waited for a processor; 0 if it has ended."""
    try:
        file = os.open(path, os.O_RDONLY)
    except OSError:
        return 0
    try:
        return int(os.read(file, _MAX_LINE).split()[1])
    except OSError:
        return 0
    finally:
        os.close(file)
