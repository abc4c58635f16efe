"""Sinks, which receive the outputs of a simulation and the commands submitted to it."""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import TYPE_CHECKING, Any, ClassVar, Protocol, TypeGuard

if TYPE_CHECKING:
    from hmrsim.protocol.commands import Command
    from hmrsim.protocol.outputs import Output
    from hmrsim.protocol.topics import Topic


class Sink(Protocol):
    """Receives the outputs of a simulation, in the simulation's thread, which it must not block.

    A sink that needs only some types of outputs, or has a function for each type, should be a `SelectiveSink`.
    """

    def emit(self, output: Output) -> None:
        """Process an output of the simulation."""

    def wants(self, topic: Topic) -> bool:
        """Return whether the sink needs a topic; the simulation does not compute topics that no sink needs."""


class SelectiveSink:
    """A base class of sinks that process only some types of outputs, each type with a separate function.

    Attributes:
        varies: Whether the result of `handler_for` depends on subscribers, so that it is called again when they change.
    """

    varies: ClassVar[bool] = False

    @property
    def topics(self) -> Collection[Topic]:
        """The topics that the sink needs now; a subclass may override `wants` instead."""
        return ()

    def wants(self, topic: Topic) -> bool:
        """Return whether the sink needs a topic now."""
        return topic in self.topics

    def emit(self, output: Output) -> None:
        """Process an output of the simulation, if there is a handler for its type."""
        if handler := self.handler_for(type(output)):
            handler(output)

    def handler_for(self, kind: type) -> Callable[[Any], object] | None:
        """Return the function that processes outputs of a type; None to ignore them.

        The simulator calls this once for each type, and then calls the function instead of `emit`.
        """
        raise NotImplementedError


class CommandSink(Sink, Protocol):
    """A sink that receives commands, too."""

    def commanded(self, command: Command, by: str, now: float) -> None:
        """Process a command from outside, after all events of this instant and before the command is applied.

        Args:
            command: The command.
            by: The participant that sent the command; empty if it comes from elsewhere.
            now: The simulated time, in seconds.
        """


def hears_commands(sink: Sink) -> TypeGuard[CommandSink]:
    """Return whether a sink receives commands, too."""
    return hasattr(sink, "commanded")
