"""The log of a simulator: goals, their results, and other events."""

from __future__ import annotations

import logging
import os
import queue
import sys
import threading
from collections.abc import Callable
from typing import TYPE_CHECKING, Final, Self

from hmrsim.actions import error_of
from hmrsim.cli.goal_summary import summary
from hmrsim.errors import printable
from hmrsim.events import Severity
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.program.log_options import PACKAGES, LineFormatter
from hmrsim.protocol.goal import GoalStatus
from hmrsim.protocol.outputs import EventStamped, GoalChanged
from hmrsim.protocol.topics import Topic

if TYPE_CHECKING:
    from hmrsim.protocol.outputs import Output
    from hmrsim.protocol.sinks import Sink

_FORMAT: Final = "[%(levelname)s] %(asctime)s | %(message)s"
_TIME_FORMAT: Final = "%H:%M:%S"

_MAX_WAITING: Final = 10_000
_MAX_LATER: Final = 1_000
_FLUSH_TIMEOUT: Final = 0.5

_LEVELS: Final = {
    Severity.DEBUG: logging.DEBUG,
    Severity.INFO: logging.INFO,
    Severity.WARNING: logging.WARNING,
    Severity.ERROR: logging.ERROR,
}

_log = logging.getLogger(__name__)


class EventLog:
    """A sink that logs goals when they are accepted and when they end, and other events.

    Args:
        least: Events of a lower severity are not logged.
        goals: Whether goals are.
    """

    def __init__(self, least: Severity = Severity.INFO, *, goals: bool = True) -> None:
        self._least = _LEVELS[least]
        self._goals = goals

    def wants(self, topic: Topic) -> bool:
        """Return whether it takes a topic: events, but not how robots move."""
        return topic is Topic.EVENTS

    def emit(self, output: Output) -> None:
        """Log a goal or an event."""
        if isinstance(output, GoalChanged):
            if self._goals:
                self._log_goal(output)
        elif isinstance(output, EventStamped):
            level = _LEVELS[output.event.severity]
            if level >= self._least and _log.isEnabledFor(level):
                at, text = output.stamp / NANOSECONDS, printable(output.event.describe())
                _log.log(level, "sim %.3f | %s", at, text)

    def _log_goal(self, event: GoalChanged) -> None:
        text, level = "", logging.WARNING if event.status is GoalStatus.ABORTED else logging.INFO
        if not _log.isEnabledFor(level):
            return
        if event.status is GoalStatus.ACCEPTED:
            text = f"accepted: {summary(event.goal)}" if event.goal else "accepted"
        elif event.status.terminal and event.result is not None:
            why = error_of(event.result) if event.status is GoalStatus.ABORTED else ""
            text = f"{event.status.name}{f': {why}' if why else ''}"
        if text:
            at = event.stamp / NANOSECONDS
            _log.log(level, "sim %.3f | %s %s %s", at, event.robot, event.action, printable(text))


class Later:
    """A sink that forwards goals' changes and events when the simulation is idle, so as not to delay it."""

    def __init__(self, sink: Sink) -> None:
        self._sink = sink
        self._events: list[Output] = []

    def wants(self, topic: Topic) -> bool:
        """Return whether the other sink wants a topic."""
        return self._sink.wants(topic)

    def emit(self, output: Output) -> None:
        """Buffer an event."""
        kind = type(output)
        if kind is GoalChanged or kind is EventStamped:
            self._events.append(output)
            if len(self._events) >= _MAX_LATER:
                self.hand_on()

    def hand_on(self) -> None:
        """Forward the buffered events."""
        events, self._events = self._events, []
        for event in events:
            self._sink.emit(event)


class LogLines(logging.Handler):
    """Collects all log lines while it is open, and writes them in its own thread.

    A logging thread never blocks, not even when stderr has no reader, since that could stop the simulation. When
    too many lines wait, the latest are dropped.

    Args:
        write: The function that writes lines; to stderr if None.
        level: The level of this project's loggers; other loggers have WARNING at least.
    """

    def __init__(self, write: Callable[[str], None] | None = None, level: int = logging.INFO) -> None:
        super().__init__(level)
        self.setFormatter(LineFormatter(_FORMAT, _TIME_FORMAT))
        self._write = write or _to_stderr
        self._lines: queue.SimpleQueue[str | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._run, name="hmrsim-log", daemon=True)

    def __enter__(self) -> Self:
        """Receive the root logger's lines from now on."""
        self._thread.start()
        logging.getLogger().addHandler(self)
        loggers = [logging.getLogger(name) for name in PACKAGES]
        self._levels = [(logger, logger.level) for logger in loggers]
        for logger in loggers:
            logger.setLevel(self.level)
        return self

    def __exit__(self, *_error: object) -> None:
        """Write the remaining lines, if that does not take long."""
        logging.getLogger().removeHandler(self)
        for logger, level in self._levels:
            logger.setLevel(level)
        self._lines.put(None)
        self._thread.join(_FLUSH_TIMEOUT)

    def emit(self, record: logging.LogRecord) -> None:
        """Put a line in the queue."""
        if self._lines.qsize() < _MAX_WAITING:
            self._lines.put(self.format(record))

    def _run(self) -> None:
        while (line := self._lines.get()) is not None:
            self._write(line)


def _to_stderr(line: str) -> None:
    """Write a line without Python's buffers, whose locks a blocked thread would hold for ever."""
    data = f"{line}\n".encode(errors="replace")
    try:
        while data:
            data = data[os.write(sys.__stderr__.fileno() if sys.__stderr__ else 2, data) :]
    except OSError:
        # The stream has no reader left.
        return
