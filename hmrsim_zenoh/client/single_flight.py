"""Whose turn it is: of many threads that wait, one at a time does something about it."""

from __future__ import annotations

import threading
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator


class SingleFlight:
    """Lets one thread at a time do what all of them wait for."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._who: int | None = None

    @contextmanager
    def take(self, needless: Callable[[], bool], timeout: float) -> Iterator[bool]:
        """Wait for our turn; yields whether it is, as it may have become needless, or take too long.

        Args:
            needless: Says whether there is nothing to wait for any more; asked after each turn of somebody else.
            timeout: Wall seconds.

        Raises:
            RuntimeError: It is ours already: a callback waits for what comes after it.
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
        """Let all who wait see whether it is needless."""
        with self._changed:
            self._changed.notify_all()
