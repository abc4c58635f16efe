"""Bugs, of plug-ins or ours, that raise within a simulation: each is logged and published, and all else goes on."""

from __future__ import annotations

import logging
import traceback
from typing import TYPE_CHECKING, Final

from hmrsim.errors import GoalAborted, GoalRejected, HmrsimError, printable
from hmrsim.events.simulation import InternalError

if TYPE_CHECKING:
    from collections.abc import Callable

    from hmrsim.engine.subscriptions import EventPublisher

_log = logging.getLogger(__name__)

_MAX_TEXT: Final = 300
"""Maximum characters of an exception's text."""


class InternalErrors:
    """Handles what nothing else handles.

    Args:
        publisher: Publishes an event for each.
        strict: Whether the first one ends the simulation: it is raised.
        mark: Called with the robot concerned and the error.
    """

    def __init__(self, publisher: EventPublisher, *, strict: bool, mark: Callable[[str, str], None]) -> None:
        self._publisher = publisher
        self._strict = strict
        self._mark = mark
        self._logged: set[tuple[str, type[Exception], int]] = set()
        self._publishing = False

    def handle(self, part: str, error: Exception, robot: str = "") -> None:
        """Log an error, with its traceback the first time, publish it and mark its robot.

        Args:
            part: What raised it, such as ``action dance``.
            error: The error.
            robot: The robot concerned; empty for none.

        Raises:
            Exception: The *error*, if the simulation is strict, or if it is a user's mistake such as a full disk.
        """
        mistake = isinstance(error, HmrsimError) and not isinstance(error, (GoalAborted, GoalRejected))
        if self._strict or mistake:
            raise error
        text = described(error)
        self._tell(part, error, text, robot)
        if self._publishing:
            # A sink that fails at this event, too.
            return
        self._publishing = True
        try:
            self._publisher.publish(lambda: InternalError(robot, part, text))
            if robot:
                self._mark(robot, f"{part}: {text}")
        finally:
            self._publishing = False

    def _tell(self, part: str, error: Exception, text: str, robot: str) -> None:
        frames = traceback.extract_tb(error.__traceback__)
        place = (frames[-1].filename, type(error), frames[-1].lineno or 0) if frames else ("", type(error), 0)
        known = place in self._logged
        self._logged.add(place)
        where = f"{robot}: " if robot else ""
        _log.error("%sbug in %s: %s", where, part, text, exc_info=None if known else error)


def described(error: Exception) -> str:
    """Return an error on one line, such as ``ZeroDivisionError: division by zero``."""
    text = printable(str(error))
    text = text if len(text) <= _MAX_TEXT else f"{text[:_MAX_TEXT]}…"
    return f"{type(error).__name__}: {text}" if text else type(error).__name__
