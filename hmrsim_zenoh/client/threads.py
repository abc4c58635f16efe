"""The thread of a client for deferred calls, since Zenoh's threads must not block."""

from __future__ import annotations

import heapq
import itertools
import logging
import threading
import time
from collections.abc import Callable

_log = logging.getLogger(__name__)


class Worker:
    """Calls functions after a delay, in a daemon thread.

    Args:
        at_once: Whether to start the thread now and not upon first use: that may be in Zenoh's thread, which must not
            wait for another thread to start.
    """

    def __init__(self, name: str, *, at_once: bool = True) -> None:
        self._changed = threading.Condition()
        self._due: list[tuple[float, int, Callable[[], None]]] = []
        self._order = itertools.count()
        self._closed = False
        self._name = name
        self._thread: threading.Thread | None = None
        if at_once:
            self._start()

    def after(self, delay: float, call: Callable[[], None]) -> None:
        """Call a function after *delay* wall seconds, unless the worker is closed by then."""
        with self._changed:
            if self._closed:
                return
            heapq.heappush(self._due, (time.monotonic() + delay, next(self._order), call))
            self._changed.notify()
            if self._thread is None:
                self._start()

    def close(self) -> None:
        """Drop the pending calls and wait for the running one."""
        if self._thread is None:
            # A call that comes later finds it closed.
            self._closed = True
            return
        with self._changed:
            self._closed = True
            self._due.clear()
            self._changed.notify()
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
            while not self._closed:
                if not self._due:
                    self._changed.wait()
                elif (delay := self._due[0][0] - time.monotonic()) > 0:
                    self._changed.wait(delay)
                else:
                    return heapq.heappop(self._due)[2]
            return None


class Rounds:
    """Calls functions after one to two periods, all that are due at once: to wake a thread costs more than a goal."""

    def __init__(self, worker: Worker, period: float) -> None:
        self._worker = worker
        self._period = period
        self._lock = threading.Lock()
        self._new: list[Callable[[], None]] = []
        self._old: list[Callable[[], None]] = []
        self._going = False

    def add(self, call: Callable[[], None]) -> None:
        """Call a function in the worker's thread, unless the worker is closed by then."""
        with self._lock:
            self._new.append(call)
            begins, self._going = not self._going, True
        if begins:
            self._worker.after(self._period, self._turn)

    def _turn(self) -> None:
        with self._lock:
            due, self._old, self._new = self._old, self._new, []
            self._going = bool(self._old)
        if self._going:
            self._worker.after(self._period, self._turn)
        for call in due:
            call()
