"""Turns among waiting threads: one at a time does the work that all of them wait for."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager


class SingleFlight:
    """Lets one thread at a time do the work that all of them wait for."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._who: int | None = None

    @contextmanager
    def take(self, needless: Callable[[], bool], timeout: float) -> Iterator[bool]:
        """Wait for the calling thread's turn; yield False if it became needless or timed out.

        Args:
            needless: Returns whether there is nothing left to wait for; called after each turn of another thread.
            timeout: Wall seconds.

        Raises:
            RuntimeError: The calling thread has the turn already: a callback waits for an event that comes after it.
        """
        me = threading.get_ident()
        if self._who == me:
            raise RuntimeError("a callback can't wait for what happens after it")
        with self._changed:
            patience = min(timeout, threading.TIMEOUT_MAX)
            ours = self._changed.wait_for(lambda: self._who is None or needless(), patience) and not needless()
            if ours:
                self._who = me
        try:
            yield ours
        finally:
            if ours:
                with self._changed:
                    self._who = None
                    self._changed.notify_all()

    def look(self) -> None:
        """Have all waiting threads check whether their turn is needless."""
        with self._changed:
            self._changed.notify_all()
