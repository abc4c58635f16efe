"""Sinks: receivers of the outputs of a simulation, and of the commands submitted to it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol, TypeGuard

if TYPE_CHECKING:
    from hmrsim.protocol.commands import Command
    from hmrsim.protocol.outputs import Output
    from hmrsim.protocol.topics import Topic


class Sink(Protocol):
    """Receives the outputs; called in the simulation's thread, which it must not block.

    One that needs outputs of some types only may have them in an attribute ``takes``, a frozenset of those types.
    """

    def emit(self, output: Output) -> None:
        """Take an output."""

    def wants(self, topic: Topic) -> bool:
        """Return whether the topic has a subscriber; a topic that no sink wants is not computed."""


class CommandSink(Sink, Protocol):
    """A sink that receives commands, too."""

    def commanded(self, command: Command, by: str, now: float) -> None:
        """Take a command from outside, before it is applied, after all that is due at this instant.

        Args:
            command: The command.
            by: The participant that sent it, if one did.
            now: The simulated time, in seconds.
        """


def hears_commands(sink: Sink) -> TypeGuard[CommandSink]:
    """Return whether a sink receives commands, too."""
    return hasattr(sink, "commanded")
