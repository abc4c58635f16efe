"""A trace that is written on demand: most runs of a test never need theirs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from hmrsim.protocol.commands import UNRECORDED, without_receivers
from hmrsim.protocol.outputs import EventStamped, GoalChanged, TimeRestarted
from hmrsim.protocol.sinks import SelectiveSink
from hmrsim.protocol.topics import Topic
from hmrsim.trace.writer import Header, Trace

if TYPE_CHECKING:
    from collections.abc import Callable

    from hmrsim.protocol.commands import Command
    from hmrsim.protocol.outputs import Output
    from hmrsim.settings.run import RunSettings
    from hmrsim.world.model import World


class _Commanded(NamedTuple):
    """A command, the participant that sent it, and when."""

    command: Command
    by: str
    now: float


class DeferredTrace(SelectiveSink):
    """A sink that collects the immutable outputs of a run, and writes them as a `Trace` on demand.

    Args:
        world: The world of the run.
        settings: The settings of the run.
    """

    def __init__(self, world: World, settings: RunSettings) -> None:
        self._world, self._settings = world, settings
        self._kept: list[Output | _Commanded] = []
        self._pieces: list[str] = []
        self._trace: Trace | None = None

    @property
    def text(self) -> str:
        """The text of the trace so far."""
        self._written().flush()
        return "".join(self._pieces)

    def whole(self, now: float) -> str:
        """Return the trace of a run that has ended at this time, in simulated seconds."""
        self._written().close(now)
        return "".join(self._pieces)

    def _written(self) -> Trace:
        trace = self._trace = self._trace or Trace(Header.of(self._world, self._settings), self._pieces.append)
        for kept in self._kept:
            if isinstance(kept, _Commanded):
                trace.commanded(*kept)
            else:
                trace.emit(kept)
        self._kept.clear()
        return trace

    def wants(self, topic: Topic) -> bool:
        """Return whether it takes a topic: what happens, but no samples."""
        return topic is Topic.EVENTS

    def handler_for(self, kind: type) -> Callable[[Any], object] | None:
        """Return the function that processes outputs of a type; None to ignore them."""
        return self._kept.append if kind in (EventStamped, GoalChanged, TimeRestarted) else None

    def commanded(self, command: Command, by: str, now: float) -> None:
        """Record a command for later."""
        if not isinstance(command, UNRECORDED):
            self._kept.append(_Commanded(without_receivers(command), by, now))
