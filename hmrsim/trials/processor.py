"""What this process, and the processes that it has started, have used of the processor."""

from __future__ import annotations

import os
import resource
import sys
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Final, NamedTuple

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
