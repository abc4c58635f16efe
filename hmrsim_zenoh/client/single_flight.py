"""Turns among waiting threads: one at a time does the work that all of them wait for."""

from __future__ import annotations

import threading
from collections.abc import Callable


class SingleFlight:
    """Lets one thread at a time do the work that all of them wait for."""

    def __init__(self) -> None:
        # Taken directly where nobody has to be woken: a condition does it in Python.
        self._lock = threading.RLock()
        self._changed = threading.Condition(self._lock)
        self._waiting = 0
        self._who: int | None = None

    @property
    def held(self) -> bool:
        """Whether it is the calling thread's turn."""
        return self._who == threading.get_ident()

    def run(self, work: Callable[[], bool], needless: Callable[[], bool], timeout: float) -> bool:
        """Wait for the calling thread's turn and work; an interrupt at any time ends the turn.

        Args:
            work: Called unless it became needless before this thread's turn came, or the time was over.
            needless: Returns whether there is nothing left to wait for; called after each turn of another thread.
            timeout: Wall seconds.

        Returns:
            What *work* returned; False if it was not called.

        Raises:
            RuntimeError: The calling thread has the turn already: a callback waits for an event that comes after it.
        """
        me = threading.get_ident()
        if self._who == me:
            raise RuntimeError("a callback can't wait for what happens after it")
        try:
            with self._lock:
                if needless() or (self._who is not None and not self._free(needless, timeout)):
                    return False
                self._who = me
            return work()
        finally:
            if self._who == me:
                with self._lock:
                    self._who = None
                    if self._waiting:
                        self._changed.notify_all()

    def _free(self, needless: Callable[[], bool], timeout: float) -> bool:
        """Wait until it is this thread's turn; return False if that is needless by then, or the time is over."""
        self._waiting += 1
        try:
            patience = min(timeout, threading.TIMEOUT_MAX)
            return self._changed.wait_for(lambda: self._who is None or needless(), patience) and not needless()
        finally:
            self._waiting -= 1

    def look(self) -> None:
        """Have all waiting threads check whether their turn is needless."""
        with self._changed:
            self._changed.notify_all()
