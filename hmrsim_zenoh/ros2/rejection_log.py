"""The log of rejected requests and incompatible clients, which does not repeat lines."""

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
"""The largest number of lines in a wall minute: a client that keeps changing its id could fill the disk."""
_MINUTE: Final = 60.0
_REMEMBERED: Final = 1_000
"""The number of remembered lines, which are not repeated; the oldest are forgotten."""


class RejectionLog:
    """Logs each line once, and at most `MAX_PER_MINUTE` lines a minute; for any thread.

    Args:
        clock: Returns the wall time in seconds.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._lock = threading.Lock()
        self._logged: OrderedDict[Hashable, None] = OrderedDict()
        self._since = clock()
        self._count = 0

    def warn(self, text: str, client: str = "") -> None:
        """Log a line, once for each client."""
        if self.due((client, text)):
            _log.warning("%s", printable(text))

    def due(self, line: Hashable) -> bool:
        """Return whether to log a line now; if so, it counts as logged."""
        with self._lock:
            if line in self._logged:
                self._logged.move_to_end(line)
                return False
            self._start_new_minute()
            self._count += 1
            if self._count > MAX_PER_MINUTE:
                return False
            self._logged[line] = None
            if len(self._logged) > _REMEMBERED:
                self._logged.popitem(last=False)
            return True

    def _start_new_minute(self) -> None:
        now = self._clock()
        if now - self._since < _MINUTE:
            return
        suppressed = self._count - MAX_PER_MINUTE
        self._since, self._count = now, 0
        if suppressed > 0:
            _log.warning("ROS 2: suppressed %d more warnings in a minute", suppressed)
