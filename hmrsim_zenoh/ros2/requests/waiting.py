"""The pending get_result requests by client: those of a gone client are dropped, and their number is limited."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from typing import TYPE_CHECKING, Final

from hmrsim.protocol.commands import GetResult, StopWaiting

if TYPE_CHECKING:
    from hmrsim_zenoh.ros2.requests.pending import PendingRosReply

MAX_WAITING: Final = 16_384
"""The largest number of pending requests for results."""
MAX_PER_CLIENT: Final = 1_024
"""… of one client."""
MAX_ANONYMOUS: Final = 32
"""… for one goal, of clients without an id, which can't be noticed to have gone: most have given up long ago."""


class PendingResults:
    """The requests for results that have not been answered; for any thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._of: dict[str, dict[PendingRosReply, GetResult]] = {}
        self._whose: dict[PendingRosReply, str] = {}

    def add(self, pending: PendingRosReply, command: GetResult) -> list[StopWaiting]:
        """Remember a request; return the commands that drop another one if there are too many now.

        That is the oldest of the same client, or the oldest of the client with the most if the total is too large.
        """
        whose = pending.client or f"goal {command.goal_id}"
        with self._lock:
            requests = self._of.setdefault(whose, {})
            requests[pending], self._whose[pending] = command, whose
            if len(requests) > (MAX_PER_CLIENT if pending.client else MAX_ANONYMOUS):
                return self._make_room(whose)
            if len(self._whose) > MAX_WAITING:
                return self._make_room(max(self._of, key=lambda one: len(self._of[one])))
        return []

    def answered(self, pending: PendingRosReply) -> None:
        """Forget a request that has been answered."""
        with self._lock:
            self._forget(pending)

    def gone(self, client: str) -> list[StopWaiting]:
        """Forget all requests of a client that has gone; return the commands that drop them."""
        with self._lock:
            requests = self._of.pop(client, {})
            for pending in requests:
                del self._whose[pending]
        return _stop_waiting(requests)

    def _make_room(self, whose: str) -> list[StopWaiting]:
        pending, command = next(iter(self._of[whose].items()))
        self._forget(pending)
        return [stop._replace(tell=True) for stop in _stop_waiting({pending: command})]

    def _forget(self, pending: PendingRosReply) -> None:
        whose = self._whose.pop(pending, None)
        if whose is not None:
            del self._of[whose][pending]
            if not self._of[whose]:
                del self._of[whose]


def _stop_waiting(requests: Mapping[PendingRosReply, GetResult]) -> list[StopWaiting]:
    """Return the commands that drop requests, one for each goal."""
    of_goals: dict[tuple[str, str, str], list[PendingRosReply]] = {}
    for pending, command in requests.items():
        of_goals.setdefault((command.robot, command.action, command.goal_id), []).append(pending)
    return [StopWaiting(*goal, tuple(found)) for goal, found in of_goals.items()]
