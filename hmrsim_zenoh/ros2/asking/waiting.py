"""Who waits for a result, by client: of clients that have gone, nobody waits any more."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, Final

from hmrsim.gateway import GetResult, Withdraw

if TYPE_CHECKING:
    from hmrsim_zenoh.ros2.asking.asked import Asked

MOST: Final = 16_384
"""Requests for results that may wait."""


class Waiting:
    """Remembers the requests for results that have not been answered; from any thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._of: dict[str, dict[Asked, Withdraw]] = {}
        self._count = 0

    def add(self, asked: Asked, command: GetResult) -> bool:
        """Remember a request; return False if too many wait already."""
        with self._lock:
            if self._count >= MOST:
                return False
            self._count += 1
            withdraw = Withdraw(command.robot, command.action, command.goal_id, asked)
            self._of.setdefault(asked.client, {})[asked] = withdraw
        return True

    def answered(self, asked: Asked) -> None:
        """Forget a request, if it was remembered."""
        with self._lock:
            requests = self._of.get(asked.client, {})
            if requests.pop(asked, None) is not None:
                self._count -= 1
            if not requests:
                self._of.pop(asked.client, None)

    def gone(self, client: str) -> list[Withdraw]:
        """Forget all requests of a client that has gone; return what takes them back."""
        with self._lock:
            requests = self._of.pop(client, {})
            self._count -= len(requests)
        return list(requests.values())
