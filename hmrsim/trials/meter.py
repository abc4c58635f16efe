"""The time that a run has used: wall time, and processor time of this process and its children."""

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
"""Of the fields of ``/proc/PID/stat`` after the name: user and system time, its own and that of its ended children."""
_LINE: Final = 128
"""More than the bytes of ``/proc/PID/task/TID/schedstat``."""
_PARENT: Final = 1
"""The place of the parent's id among these fields."""


class Usage(NamedTuple):
    """Seconds since this process has started, of all its threads and of all processes that descend from it.

    Attributes:
        used: Processor time.
        delayed: Time in which they could have computed, but other processes had the processor; 0 where the system
            does not say so, as only Linux does.
    """

    used: float
    delayed: float

    @classmethod
    def now(cls) -> Usage:
        """Return what was used so far. Of running children only Linux says what they use; others count at their end."""
        ended = resource.getrusage(resource.RUSAGE_CHILDREN)
        used = time.process_time() + ended.ru_utime + ended.ru_stime
        delayed = _delayed("self")
        for process, seconds in _descendants():
            used += seconds
            delayed += _delayed(process)
        return cls(used, delayed)


def _descendants() -> Iterator[tuple[str, float]]:
    """Yield the processes that this one has started, and those that they have, each with its processor time."""
    if sys.platform != "linux" or not _has_children():
        return
    children: dict[str, list[tuple[str, float]]] = {}
    tick = 1.0 / os.sysconf("SC_CLK_TCK")
    # Not by /proc/PID/task/TID/children: each thread has one, and it may leave out some while others end.
    for path in _PROCESSES.glob("[0-9]*/stat"):
        with suppress(OSError):  # it has ended meanwhile
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
    """Return whether there are any, which takes a thousandth of the time that it takes to look at all processes."""
    try:
        os.waitid(os.P_ALL, 0, os.WEXITED | os.WNOHANG | os.WNOWAIT)
    except ChildProcessError:
        return False
    return True


def _delayed(process: str) -> float:
    """Return for how long the threads of a process waited for a processor."""
    threads = f"{_PROCESSES}/{process}/task"
    try:
        found = os.listdir(threads)  # noqa: PTH208 - a process may have hundreds of threads
    except OSError:  # it has ended meanwhile, or the system has no such files
        return 0.0
    return sum(_waited(f"{threads}/{thread}/schedstat") for thread in found) * _NANO


def _waited(path: str) -> int:
    """Return for how many nanoseconds a thread waited for a processor; 0 if it has ended meanwhile."""
    try:
        file = os.open(path, os.O_RDONLY)
    except OSError:
        return 0
    try:
        return int(os.read(file, _LINE).split()[1])
    except OSError:
        return 0
    finally:
        os.close(file)


_BETWEEN_LOOKS: Final = 0.02
"""Wall seconds between two looks at least."""
_PATIENCE: Final = 0.5
"""The part of the shortest limit within which a run has to end when its time is over."""
_GRACE: Final = 5.0
"""Wall seconds to add to that."""


class Meter:
    """Measures what a run takes, from now on.

    Time of the wall in which the run could compute, but other processes have the processor, counts for no limit.

    Args:
        limits: The limits of the run.
        seconds: Wall seconds after which its time is over in any case.
        clock: Returns the wall's time, in seconds.
        usage: Returns what was used of the processor.

    Attributes:
        why: Which of its times is over, in words; empty while none is.
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
        # In this order, and in that of `look`, what happens between the two readings counts as no wait.
        self._at_first = self._before = usage()
        self._began = self._looked = clock()
        self._busy = 0.0

    @property
    def left(self) -> float:
        """Wall seconds until one of its times may be over."""
        used = self._before.used - self._at_first.used
        since = self._looked - self._began
        return max(_BETWEEN_LOOKS, min(self._wall - since + self._busy, self._processor - used, self._seconds - since))

    @property
    def patience(self) -> float:
        """Wall seconds until a run counts as ignoring its limit, if no check happens earlier."""
        return self.left + _PATIENCE * min(self._wall, self._processor) + _GRACE

    def look(self) -> bool:
        """Measure; return whether one of its times is over."""
        self._looked = self._clock()
        usage, before = self._usage(), self._before
        self._before = usage
        # A thread that ends takes its delays with it, and so does a process.
        self._busy += max(0.0, usage.used - before.used) + max(0.0, usage.delayed - before.delayed)
        since = self._looked - self._began
        if usage.used - self._at_first.used >= self._processor:
            self.why = f"it takes longer than {self._processor:g} s of processor time"
        elif since - self._busy >= self._wall:
            self.why = f"it has waited for {self._wall:g} wall seconds without computing anything"
        elif since >= self._seconds:
            self.why = f"it takes longer than the {self._seconds:.3g} wall seconds that were left for it"
        return bool(self.why)
