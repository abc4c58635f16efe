"""The log of a simulation: goals, their results and other events as lines of text."""

from __future__ import annotations

import logging
import os
import queue
import sys
import threading
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from typing import TYPE_CHECKING, Any, Final, Self

from pydantic import ValidationError

from hmrsim.actions import error_of
from hmrsim.actions import registry as actions
from hmrsim.cli.worlds import policy_line
from hmrsim.errors import printable
from hmrsim.events import Severity
from hmrsim.events.goals import GoalAccepted
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS, Duration, Time
from hmrsim.interfaces.geometry_msgs import Pose, PoseStamped
from hmrsim.interfaces.message import Message
from hmrsim.program.log_options import PACKAGES, LineFormatter
from hmrsim.protocol.goal import GoalStatus
from hmrsim.protocol.outputs import EventStamped, GoalChanged
from hmrsim.protocol.topics import Topic

if TYPE_CHECKING:
    from hmrsim.events import Event
    from hmrsim.protocol.outputs import Output
    from hmrsim.protocol.sinks import Sink
    from hmrsim.simulation.simulator import Simulator
    from hmrsim_zenoh.hosting.host import Host


_FORMAT: Final = "[%(levelname)s] %(asctime)s | %(message)s"
_TIME_FORMAT: Final = "%H:%M:%S"

_MAX_WAITING: Final = 10_000
_MAX_BUFFERED: Final = 1_000
_FLUSH_TIMEOUT: Final = 0.5

_LEVELS: Final = {
    Severity.DEBUG: logging.DEBUG,
    Severity.INFO: logging.INFO,
    Severity.WARNING: logging.WARNING,
    Severity.ERROR: logging.ERROR,
}

_log = logging.getLogger(__name__)


class EventLog:
    """A sink that logs events, and goals when they are accepted and when they end.

    Args:
        least: The lowest severity of events to log.
        goals: Whether to log goals.
    """

    def __init__(self, least: Severity = Severity.INFO, *, goals: bool = True) -> None:
        self._least = _LEVELS[least]
        self._goals = goals

    def wants(self, topic: Topic) -> bool:
        """Return whether a topic is logged: events are, motion is not."""
        return topic is Topic.EVENTS

    def emit(self, output: Output) -> None:
        """Log a goal or an event."""
        if isinstance(output, GoalChanged):
            if self._goals:
                self._log_goal(output)
        elif isinstance(output, EventStamped) and not isinstance(output.event, GoalAccepted):
            # An accepted goal is logged as a change, which is published even without a subscriber to this event.
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


class GoalCounter:
    """A sink that counts goals by their final status."""

    def __init__(self) -> None:
        self.statuses: Counter[str] = Counter()

    def wants(self, _topic: Topic) -> bool:
        """Return False: final statuses of goals are delivered anyway."""
        return False

    def emit(self, output: Output) -> None:
        """Count a goal that has ended."""
        if isinstance(output, GoalChanged) and output.status.terminal:
            self.statuses[output.status.name] += 1


class BufferedSink:
    """A sink that forwards goals and events while the simulation is idle, so that it does not wait for the log."""

    def __init__(self, sink: Sink) -> None:
        self._sink = sink
        self._events: list[Output] = []

    def wants(self, topic: Topic) -> bool:
        """Return whether the wrapped sink wants a topic."""
        return self._sink.wants(topic)

    def emit(self, output: Output) -> None:
        """Buffer a goal or an event."""
        kind = type(output)
        if kind is GoalChanged or kind is EventStamped:
            self._events.append(output)
            if len(self._events) >= _MAX_BUFFERED:
                self.forward()

    def forward(self) -> None:
        """Forward the buffered outputs to the sink."""
        events, self._events = self._events, []
        for event in events:
            self._sink.emit(event)


class LogLines(logging.Handler):
    """Collects log lines while it is open, and writes them in its own thread.

    Logging never blocks a thread, even if stderr has no reader, since that could stop the simulation. If too many
    lines are waiting, new ones are dropped.

    Args:
        write: Writes a line; None for stderr.
        level: The level of this project's loggers; other loggers keep theirs.
    """

    def __init__(self, write: Callable[[str], None] | None = None, level: int = logging.INFO) -> None:
        super().__init__(level)
        self.setFormatter(LineFormatter(_FORMAT, _TIME_FORMAT))
        self._write = write or _to_stderr
        self._lines: queue.SimpleQueue[str | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._run, name="hmrsim-log", daemon=True)

    def __enter__(self) -> Self:
        """Start to receive the root logger's records."""
        self._thread.start()
        logging.getLogger().addHandler(self)
        loggers = [logging.getLogger(name) for name in PACKAGES]
        self._levels = [(logger, logger.level) for logger in loggers]
        for logger in loggers:
            logger.setLevel(self.level)
        return self

    def __exit__(self, *_error: object) -> None:
        """Write the remaining lines, unless that takes long."""
        logging.getLogger().removeHandler(self)
        for logger, level in self._levels:
            logger.setLevel(level)
        self._lines.put(None)
        self._thread.join(_FLUSH_TIMEOUT)

    def emit(self, record: logging.LogRecord) -> None:
        """Queue the line of a record for the writing thread; drop it if too many wait."""
        if self._lines.qsize() < _MAX_WAITING:
            self._lines.put(self.format(record))

    def _run(self) -> None:
        while (line := self._lines.get()) is not None:
            self._write(line)


def _to_stderr(line: str) -> None:
    """Write a line without Python's buffers, whose locks a blocked thread would hold forever."""
    data = f"{line}\n".encode(errors="replace")
    try:
        while data:
            data = data[os.write(sys.__stderr__.fileno() if sys.__stderr__ else 2, data) :]
    except OSError:
        # The reader has closed the stream.
        return


class LogDisplay:
    """The display of a run as log lines."""

    def __init__(self, world: str, level: int) -> None:
        self._world = printable(world)
        self._level = level
        self._events = BufferedSink(EventLog())
        self.sinks: Sequence[Sink] = (self._events,)
        self.on_wait: Sequence[Callable[[], None]] = (self._events.forward,)
        self.preparations: Iterable[object] = ()
        if level <= logging.INFO:
            self.preparations = (summary(action.goal()) for action in actions().values())

    @contextmanager
    def shown(self, host: Host) -> Iterator[Callable[[], None]]:
        """Write log lines, and yield a function that does nothing."""
        with LogLines(level=self._level):
            _log.info("sim %.3f | %s begins", host.simulator.now, self._world)
            log_policy(host.simulator)
            if awaited := host.pacing.state.waiting_for:
                _log.info("sim %.3f | time stands, waiting for %s", host.simulator.now, ", ".join(awaited))
            yield lambda: None
            self._events.forward()
            _log.info("sim %.3f | %s ends", host.simulator.now, self._world)


def log_policy(simulator: Simulator) -> None:
    """Log the traffic policy in force."""
    if policy := policy_line(simulator.world):
        _log.info("sim %.3f | %s", simulator.now, policy)


def text_of(event: Event) -> str:
    """Return the text of an event without its subject; empty for events that are too frequent for a log."""
    if event.severity is Severity.DEBUG:
        return ""
    return event.text({"goal": lambda _goal: _goal_of(event)}) if isinstance(event, GoalAccepted) else event.text()


def _goal_of(event: GoalAccepted) -> str:
    action = actions().get(event.action)
    try:
        return summary(action.goal.model_validate(event.goal)) if action else ""
    except ValidationError:
        # The simulator has another version.
        return ""


_MAX_PARTS: Final = 3


def summary(goal: Message) -> str:
    """Return a goal in a few words: points, names, durations, and numbers that are not the default."""
    words = list(_words(goal))
    rest = [f"and {len(words) - _MAX_PARTS} more"] if len(words) > _MAX_PARTS else []
    return ", ".join([*words[:_MAX_PARTS], *rest])


@cache
def _defaults(kind: type[Message]) -> dict[str, Any]:
    return {name: field.get_default(call_default_factory=True) for name, field in kind.model_fields.items()}


def _words(value: object) -> Iterator[str]:
    if isinstance(value, PoseStamped):
        yield from _words(value.pose)
    elif isinstance(value, Pose):
        yield f"({value.position.x:g}, {value.position.y:g})"
    elif isinstance(value, Duration):
        yield f"{value.to_seconds():g} s"
    elif isinstance(value, list):
        for item in value:
            yield from _words(item)
    elif isinstance(value, Message) and not isinstance(value, Time):
        shown = False
        for name, default in _defaults(type(value)).items():
            part = getattr(value, name)
            # Clients send every field, so most have ROS's defaults. A pose at the origin is a valid target, unless a
            # field before it, such as the name of a dock, says where to drive.
            if part != default or (not shown and isinstance(part, (Pose, PoseStamped))):
                shown = True
                yield from _words(part)
    elif isinstance(value, (str, int, float)) and value:
        yield str(value) if isinstance(value, str) else f"{value:g}"
