"""Publication on the keys of a session, and the rate limit of published feedback."""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Callable
from contextlib import suppress
from typing import TYPE_CHECKING, Final

import zenoh

if TYPE_CHECKING:
    from hmrsim.protocol.outputs import FeedbackSent

_log = logging.getLogger(__name__)

_BLOCK, _DROP = zenoh.CongestionControl.BLOCK, zenoh.CongestionControl.DROP

_MAX_PER_GOAL: Final = 20
"""Feedback messages of one goal per wall second."""
_MAX_PER_SECOND: Final = 2_000
"""Feedback messages of all goals per wall second: more would take most of the simulator's processor time."""


class Publisher:
    """Publishes on the keys of a session, and declares the keys that it serves.

    Args:
        declares: Whether to declare keys upon first use. Zenoh compares an undeclared key with all declared ones: where
            1,000 robots have liveliness tokens, that adds 0.13 ms to a query and 0.5 ms to a publication. In larger
            worlds, which have no tokens, declaring keys would take minutes.

    Attributes:
        timestamp: Returns a timestamp of the session, later than all earlier ones.
    """

    def __init__(self, session: zenoh.Session, *, declares: bool) -> None:
        self.timestamp: Callable[[], zenoh.Timestamp] = session.new_timestamp
        self._session = session
        self._declares = declares
        self._keys: dict[str, zenoh.KeyExpr | str] = {}

    def put(self, key: str, payload: bytes, mime: str, *, reliable: bool = False) -> None:
        """Publish; a best-effort message is dropped when a subscriber is slow."""
        try:
            self.declare(key)
            control = _BLOCK if reliable else _DROP
            self._session.put(self._keys[key], payload, encoding=mime, congestion_control=control)
        except zenoh.ZError as error:
            _log.debug("publishing on %s: %s", key, error)

    def declare(self, key: str) -> None:
        """Declare a key, unless it is declared already, or keys are not.

        Raises:
            ZError: The session is closed.
        """
        if key not in self._keys:
            self._keys[key] = self._session.declare_keyexpr(key) if self._declares else key

    def forget(self, is_unused: Callable[[str], bool]) -> None:
        """Undeclare unused keys, which Zenoh would keep."""
        for key in [key for key in self._keys if is_unused(key)]:
            declared = self._keys.pop(key)
            if isinstance(declared, zenoh.KeyExpr):
                with suppress(zenoh.ZError):
                    self._session.undeclare(declared)


class FeedbackLimiter:
    """Limits the rate of each goal's feedback, and so that of all goals; a goal's last feedback always passes.

    Attributes:
        sent: When feedback of each goal was last published, until the goal is forgotten.
    """

    def __init__(self) -> None:
        self.sent: dict[str, float] = {}

    def passes(self, event: FeedbackSent) -> bool:
        """Return whether to publish feedback; if so, it counts as published."""
        now = time.monotonic()
        period = max(1 / _MAX_PER_GOAL, len(self.sent) / _MAX_PER_SECOND)
        if not event.last and now - self.sent.get(event.goal_id, -math.inf) < period:
            return False
        self.sent[event.goal_id] = now
        return True

    def forget(self, goal_id: str) -> None:
        """Forget a goal that has ended."""
        self.sent.pop(goal_id, None)
