"""The thread in which a client runs its deferred calls, since Zenoh's threads must not block."""

from __future__ import annotations

import heapq
import itertools
import logging
import math
import threading
import time
from collections.abc import Callable

_log = logging.getLogger(__name__)


class Worker:
    """Calls functions after a delay, in a daemon thread.

    Args:
        at_once: Whether to start the thread now instead of upon first use, which may be in Zenoh's thread, where
            waiting for another thread to start is not allowed.
        most: The number of calls that may wait; a further one replaces the first.
    """

    def __init__(self, name: str, *, at_once: bool = True, most: float = math.inf) -> None:
        # Taken for each call; a condition does it in Python.
        self._lock = threading.RLock()
        self._changed = threading.Condition(self._lock)
        self._due: list[tuple[float, int, Callable[[], None]]] = []
        self._order = itertools.count()
        self._closed = self._calling = False
        self._name = name
        self._most = most
        self._thread: threading.Thread | None = None
        if at_once:
            self._start()

    def after(self, delay: float, call: Callable[[], None], *, rounded: bool = False) -> None:
        """Call a function after *delay* wall seconds, unless the worker is closed by then.

        If *rounded*, the delay may be up to twice as long, so that many functions become due together: waking the
        thread takes more time than a goal.
        """
        with self._lock:
            if self._closed:
                return
            at = time.monotonic() + delay
            due = (math.ceil(at / delay) * delay if rounded else at, next(self._order), call)
            if len(self._due) >= self._most:
                heapq.heappop(self._due)
            heapq.heappush(self._due, due)
            if self._thread is None:
                self._start()
            elif self._due[0] is due:
                self._changed.notify_all()

    def settle(self) -> None:
        """Wait until all calls have been made, or the worker is closed."""
        with self._changed:
            self._changed.wait_for(lambda: self._closed or not (self._due or self._calling))

    def close(self) -> None:
        """Drop the pending calls and wait for the running one."""
        if self._thread is None:
            # A later call of `after` finds the worker closed.
            self._closed = True
            return
        with self._changed:
            self._closed = True
            self._due.clear()
            self._changed.notify_all()
        if self._thread is not threading.current_thread():
            self._thread.join()

    def _start(self) -> None:
        self._thread = threading.Thread(target=self._run, name=self._name, daemon=True)
        self._thread.start()

    def _run(self) -> None:
        while (call := self._next()) is not None:
            try:
                call()
            except Exception:  # noqa: BLE001 - an error in one callback must not stop the others
                _log.exception("a delayed call failed")

    def _next(self) -> Callable[[], None] | None:
        with self._changed:
            self._calling = False
            self._changed.notify_all()
            while not self._closed:
                if not self._due:
                    self._changed.wait()
                elif (delay := self._due[0][0] - time.monotonic()) > 0:
                    self._changed.wait(delay)
                else:
                    self._calling = True
                    return heapq.heappop(self._due)[2]
            return None
