"""What ROS clients are told through the log: ROS's replies have no field for why."""

from __future__ import annotations

import logging
import threading
from typing import Final

from hmrsim.errors import printable

_log = logging.getLogger(__name__)

_MOST: Final = 1_000
"""Things that are said; whoever invents ids could fill a disk."""


class Complaints:
    """Says each thing once for each client, from any thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._said: set[tuple[str, str, str]] = set()

    def say(self, client: str, service: str, text: str, kind: str = "") -> None:
        """Say what is wrong, if it was not said before.

        Args:
            client: The client's id in hex; empty if it has none.
            service: What it asked.
            text: What is wrong, and what would do.
            kind: What tells it from other mistakes of the same client at the same place.
        """
        with self._lock:
            what = (client, service, kind)
            if what in self._said or len(self._said) >= _MOST:
                return
            self._said.add(what)
            last = len(self._said) == _MOST
        who = f"client {client}" if client else "a client without an id"
        _log.warning("ROS 2: %s: %s: %s%s", who, service, printable(text), "; no more is said" if last else "")
