"""The pending get_result requests by client: those of a gone client are dropped, and their number is limited."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, Final

from hmrsim.protocol.commands import GetResult, StopWaiting

if TYPE_CHECKING:
    from collections.abc import Mapping

    from hmrsim_zenoh.ros2.requests.pending import PendingRosReply

MAX_WAITING: Final = 16_384
"""Requests for results that may wait."""
MAX_PER_CLIENT: Final = 1_024
"""… of one client."""
MAX_ANONYMOUS: Final = 32
"""… for one goal, of clients that don't say who they are, nor that they have gone: most have given up long ago."""


class PendingResults:
    """Remembers the requests for results that have not been answered; from any thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._of: dict[str, dict[PendingRosReply, GetResult]] = {}
        self._whose: dict[PendingRosReply, str] = {}

    def add(self, asked: PendingRosReply, command: GetResult) -> list[StopWaiting]:
        """Remember a request; return what takes back another for which there is no room then: its sender's oldest.

        If there is no room at all, it is the oldest request of the client with the most.
        """
        whose = asked.client or f"goal {command.goal_id}"
        with self._lock:
            requests = self._of.setdefault(whose, {})
            requests[asked], self._whose[asked] = command, whose
            if len(requests) > (MAX_PER_CLIENT if asked.client else MAX_ANONYMOUS):
                return self._make_room(whose)
            if len(self._whose) > MAX_WAITING:
                return self._make_room(max(self._of, key=lambda one: len(self._of[one])))
        return []

    def answered(self, asked: PendingRosReply) -> None:
        """Forget a request, if it was remembered."""
        with self._lock:
            self._forget(asked)

    def gone(self, client: str) -> list[StopWaiting]:
        """Forget all requests of a client that has gone; return what takes them back."""
        with self._lock:
            requests = self._of.pop(client, {})
            for asked in requests:
                del self._whose[asked]
        return _withdrawn(requests)

    def _make_room(self, whose: str) -> list[StopWaiting]:
        asked, command = next(iter(self._of[whose].items()))
        self._forget(asked)
        return [withdraw._replace(tell=True) for withdraw in _withdrawn({asked: command})]

    def _forget(self, asked: PendingRosReply) -> None:
        whose = self._whose.pop(asked, None)
        if whose is not None:
            del self._of[whose][asked]
            if not self._of[whose]:
                del self._of[whose]


def _withdrawn(requests: Mapping[PendingRosReply, GetResult]) -> list[StopWaiting]:
    """Return what takes requests back, one for each goal."""
    of_goals: dict[tuple[str, str, str], list[PendingRosReply]] = {}
    for asked, command in requests.items():
        of_goals.setdefault((command.robot, command.action, command.goal_id), []).append(asked)
    return [StopWaiting(*goal, tuple(found)) for goal, found in of_goals.items()]
