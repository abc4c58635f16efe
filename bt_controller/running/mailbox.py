"""The mailbox by which other threads and signals wake a runner."""

from __future__ import annotations

from queue import Empty, SimpleQueue
from typing import Final

CLOCK: Final = "/clock"
"""The awaited time has come."""
RESET: Final = "/reset"
"""Time went back."""
STOP: Final = "/stop"
"""The user requests the end."""


class Mailbox:
    """Collects the reasons to wake: a robot's name, `CLOCK`, `RESET` or `STOP`.

    Any thread may put, and so may a signal handler that interrupts the thread which waits.
    """

    def __init__(self) -> None:
        # A condition would do for threads; but a signal between its test and its wait would be lost.
        self._queue: SimpleQueue[str] = SimpleQueue()

    def put(self, reason: str) -> None:
        """Wake the waiting thread; returns at once."""
        self._queue.put(reason)

    def wait(self, timeout: float) -> frozenset[str]:
        """Return the reasons that came, as soon as there is one; none after *timeout* wall seconds."""
        if timeout <= 0.0 and self._queue.empty():
            return frozenset()
        try:
            reasons = {self._queue.get(timeout=timeout)}
        except Empty:
            return frozenset()
        while not self._queue.empty():
            reasons.add(self._queue.get())
        return frozenset(reasons)
