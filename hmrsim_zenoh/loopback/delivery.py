"""The turns of a simulation and of its clients, where both are in one process.

Nothing is delivered while the simulation runs: its messages wait until it pauses, and are then delivered in order by
the thread that ran it. So callbacks see the same as over a network, and may send anything.
"""

from __future__ import annotations

import itertools
import logging
import threading
from collections import deque
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from hmrsim.protocol.commands import Inbox

_log = logging.getLogger(__name__)

T = TypeVar("T")


class Delivery:
    """Runs the simulation, and delivers its messages while it pauses.

    Args:
        run: Runs the simulation until it needs a message to continue.
        inbox: The messages for the simulation.

    Attributes:
        lock: Held by the one thread that runs the simulation, or changes who receives its messages.
    """

    def __init__(self, run: Callable[[], None], inbox: Inbox) -> None:
        self.lock = threading.RLock()
        self._run = run
        self._inbox = inbox
        self._waiting: deque[Callable[[], object]] = deque()
        self._numbers = itertools.count(1)
        self._running = False
        self._settled = threading.Condition()
        self._settling = 0

    def number(self) -> int:
        """Return a number that was not returned before."""
        return next(self._numbers)

    def deliver(self, call: Callable[[T], object], item: T) -> None:
        """Call a function with an item once the simulation pauses."""
        self._waiting.append(partial(call, item))

    def settle(self, *, resume: bool = False) -> None:
        """Run the simulation and deliver the waiting messages until neither has more to do; not while it runs.

        Args:
            resume: Whether to run the simulation even if it has no message to process.
        """
        while True:
            with self.lock:
                if self._running:
                    # A callback of the simulation itself.
                    break
                if resume or self._inbox.waiting:
                    self._running = True
                    try:
                        self._run()
                    finally:
                        self._running = False
            if not self._waiting:
                break
            resume = False
            while self._waiting:
                try:
                    call = self._waiting.popleft()
                except IndexError:
                    # Another thread delivers, too.
                    break
                try:
                    call()
                except Exception:  # noqa: BLE001 - an error in one callback must not stop the others
                    _log.exception("a callback failed")
        if self._settling:
            self.notify()

    def wait_while(self, holds: Callable[[], bool]) -> None:
        """Block the calling thread while a condition holds; it is evaluated only while the simulation pauses."""

        def over() -> bool:
            return not (self._running or holds())

        if over():
            return
        with self._settled:
            self._settling += 1
            try:
                self._settled.wait_for(over)
            finally:
                self._settling -= 1

    def notify(self) -> None:
        """Wake the threads in `wait_while`."""
        with self._settled:
            self._settled.notify_all()
