"""The log of rejected requests: ROS's replies have no field for the reason."""

from __future__ import annotations

import logging
import threading
import time
from collections import OrderedDict
from collections.abc import Callable, Hashable
from typing import Final

from hmrsim.errors import printable

_log = logging.getLogger(__name__)

MAX_PER_MINUTE: Final = 20
"""The largest number of lines in a wall minute: a client with ever new ids could fill the disk."""
_MINUTE: Final = 60.0
_REMEMBERED: Final = 1_000
"""The number of lines that are not repeated; the oldest are forgotten."""


class RejectionLog:
    """Logs each line once, and at most `MAX_PER_MINUTE` lines a minute; for any thread.

    Args:
        clock: Returns the wall time in seconds.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._lock = threading.Lock()
        self._said: OrderedDict[Hashable, None] = OrderedDict()
        self._since = clock()
        self._count = 0

    def warn(self, text: str, client: str = "") -> None:
        """Log a line, once for each client."""
        if self.due((client, text)):
            _log.warning("%s", printable(text))

    def due(self, what: Hashable) -> bool:
        """Return whether to log a line now; if so, it counts as logged."""
        with self._lock:
            if what in self._said:
                self._said.move_to_end(what)
                return False
            self._look_at_the_clock()
            self._count += 1
            if self._count > MAX_PER_MINUTE:
                return False
            self._said[what] = None
            if len(self._said) > _REMEMBERED:
                self._said.popitem(last=False)
            return True

    def _look_at_the_clock(self) -> None:
        now = self._clock()
        if now - self._since < _MINUTE:
            return
        untold = self._count - MAX_PER_MINUTE
        self._since, self._count = now, 0
        if untold > 0:
            _log.warning("ROS 2: suppressed %d more warnings in a minute", untold)
