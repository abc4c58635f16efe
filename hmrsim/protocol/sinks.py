"""Sinks: receivers of the outputs of a simulation, and of the commands submitted to it."""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import TYPE_CHECKING, Any, ClassVar, Protocol, TypeGuard

if TYPE_CHECKING:
    from hmrsim.protocol.commands import Command
    from hmrsim.protocol.outputs import Output
    from hmrsim.protocol.topics import Topic


class Sink(Protocol):
    """Receives the outputs; called in the simulation's thread, which it must not block.

    One that needs outputs of some types only, or has a function for each, is a `SelectiveSink`.
    """

    def emit(self, output: Output) -> None:
        """Process an output of the simulation."""

    def wants(self, topic: Topic) -> bool:
        """Return whether the topic has a subscriber; a topic that no sink wants is not computed."""


class SelectiveSink:
    """A base class of sinks that process outputs of some types only, each with its own function.

    Attributes:
        varies: Whether `handler_for` depends on the interest of others, and has to be asked again when that changes.
    """

    varies: ClassVar[bool] = False

    @property
    def topics(self) -> Collection[Topic]:
        """The topics that it wants now; a subclass may have a `wants` instead, which is asked for each topic."""
        return ()

    def wants(self, topic: Topic) -> bool:
        """Return whether a topic is wanted now."""
        return topic in self.topics

    def emit(self, output: Output) -> None:
        """Process an output of the simulation, if it is of one of these types."""
        if handler := self.handler_for(type(output)):
            handler(output)

    def handler_for(self, kind: type) -> Callable[[Any], object] | None:
        """Return the function that processes outputs of a type; None to ignore them.

        The simulator asks once for each type, and calls the function in place of `emit`.
        """
        raise NotImplementedError


class CommandSink(Sink, Protocol):
    """A sink that receives commands, too."""

    def commanded(self, command: Command, by: str, now: float) -> None:
        """Take a command from outside, before it is applied, after all that is due at this instant.

        Args:
            command: The command.
            by: The participant that sent it, if one did.
            now: The simulated time, in seconds.
        """


def handler_of(sink: Sink, kind: type) -> Callable[[Any], object] | None:
    """Return the function by which a sink processes outputs of a type; None if it ignores them."""
    return sink.handler_for(kind) if isinstance(sink, SelectiveSink) else sink.emit


def topics_of(sink: object) -> Collection[Topic] | None:
    """Return the topics that a sink wants now; None for one that has to be asked for each."""
    if isinstance(sink, SelectiveSink) and type(sink).wants is SelectiveSink.wants:
        return sink.topics
    return None


def hears_commands(sink: Sink) -> TypeGuard[CommandSink]:
    """Return whether a sink receives commands, too."""
    return hasattr(sink, "commanded")
