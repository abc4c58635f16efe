"""Turns among waiting threads: one at a time does the work that all of them wait for."""

from __future__ import annotations

import threading
from collections.abc import Callable


class SingleFlight:
    """Lets one thread at a time do the work that all of them wait for."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._who: int | None = None

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
            with self._changed:
                patience = min(timeout, threading.TIMEOUT_MAX)
                if not self._changed.wait_for(lambda: self._who is None or needless(), patience) or needless():
                    return False
                self._who = me
            return work()
        finally:
            if self._who == me:
                with self._changed:
                    self._who = None
                    self._changed.notify_all()

    def look(self) -> None:
        """Have all waiting threads check whether their turn is needless."""
        with self._changed:
            self._changed.notify_all()
