"""The handling of bugs: an unexpected error in a simulation is logged and published, and the simulation continues."""

from __future__ import annotations

import logging
import traceback
from typing import TYPE_CHECKING, Final

from hmrsim.errors import OutputError, WriteError, printable
from hmrsim.events.simulation import InternalError, UntracedError

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable

    from hmrsim.engine.subscriptions import EventPublisher

_log = logging.getLogger(__name__)

BUGS: Final = (Exception, SystemExit, GeneratorExit)
"""What a bug of a plug-in may raise: all but what ends the program from outside, as Ctrl-C does."""

FATAL: Final = (OutputError, WriteError)
"""No bugs: an output of the run can't be written, as on a full disk."""

_MAX_TEXT: Final = 300
"""Maximum characters of an exception's text."""


class InternalErrors:
    """Handles the errors that no other code handles.

    Args:
        publisher: Publishes an event for each.
        strict: Whether the first one ends the simulation: it is raised.
        mark: Called with the robot concerned and the error.
    """

    def __init__(self, publisher: EventPublisher, *, strict: bool, mark: Callable[[str, str], None]) -> None:
        self._publisher = publisher
        self._strict = strict
        self._mark = mark
        self._logged: set[Hashable] = set()
        self._publishing = False

    def handle(self, part: str, error: BaseException, robot: str = "", *, replayed: bool = True) -> None:
        """Log an error, with its traceback the first time, publish it and mark its robot.

        Args:
            part: The part that raised it, such as ``action dance``.
            error: The error.
            robot: The robot concerned; empty for none.
            replayed: Whether a replay of the run repeats it. Effects of subscribers are not in the trace, and
                marks no robot.

        Raises:
            Exception: The *error*, if the simulation is strict.
        """
        text = described(error)
        if self._strict:
            raise error if isinstance(error, Exception) else RuntimeError(text) from error
        known = self._tell(part, error, text, robot, often=not replayed)
        if self._publishing or (known and not replayed):
            # A sink that fails at this event, too; or one that fails at each.
            return
        self._publishing = True
        try:
            kind = InternalError if replayed else UntracedError
            self._publisher.publish(lambda: kind(robot, part, text))
            if robot and replayed:
                self._mark(robot, f"{part}: {text}")
        finally:
            self._publishing = False

    def _tell(self, part: str, error: BaseException, text: str, robot: str, *, often: bool) -> bool:
        """Log an error, a frequent one only once; return whether it has been logged before."""
        *_, (frame, line) = ((None, 0), *traceback.walk_tb(error.__traceback__))
        place: Hashable = (frame and frame.f_code.co_filename, type(error), line)
        seen = (place, part, robot) if often else place
        known = seen in self._logged
        if not (known and often):
            where = f"{robot}: " if robot else ""
            _log.error("%sbug in %s: %s", where, part, text, exc_info=None if place in self._logged else error)
        self._logged |= {place, seen}
        return known


def described(error: BaseException) -> str:
    """Return an error on one line, such as ``ZeroDivisionError: division by zero``."""
    try:
        text = printable(" ".join(str(error).split()))
    except Exception:  # noqa: BLE001 - an exception of a plug-in may have a bug, too
        text = "its text can't be made"
    text = text if len(text) <= _MAX_TEXT else f"{text[:_MAX_TEXT]}…"
    return f"{type(error).__name__}: {text}" if text else type(error).__name__
