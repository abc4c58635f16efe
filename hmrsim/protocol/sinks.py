"""Sinks: receivers of the outputs of a simulation, and of the commands submitted to it."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Protocol, TypeGuard

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


class SelectiveSink(Sink, Protocol):
    """A sink that is asked once for each type of outputs."""

    def taker(self, kind: type) -> Callable[[Any], object] | None:
        """Return what takes outputs of a type in place of `emit`; None if they are not for this sink."""


class CommandSink(Sink, Protocol):
    """A sink that receives commands, too."""

    def commanded(self, command: Command, by: str, now: float) -> None:
        """Take a command from outside, before it is applied, after all that is due at this instant.

        Args:
            command: The command.
            by: The participant that sent it, if one did.
            now: The simulated time, in seconds.
        """


def taker_of(sink: Sink, kind: type) -> Callable[[Any], object] | None:
    """Return what takes outputs of a type; None if they are not for this sink."""
    selects: Callable[[type], Callable[[Any], object] | None] | None = getattr(sink, "taker", None)
    return sink.emit if selects is None else selects(kind)


def hears_commands(sink: Sink) -> TypeGuard[CommandSink]:
    """Return whether a sink receives commands, too."""
    return hasattr(sink, "commanded")
