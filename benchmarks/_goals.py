"""The goals of a run, repeated without any client: the simulation alone."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from hmrsim.protocol.commands import SendGoal
from hmrsim.simulation.simulator import Simulator

if TYPE_CHECKING:
    from hmrsim.protocol.commands import Command
    from hmrsim.protocol.outputs import Output
    from hmrsim.protocol.topics import Topic
    from hmrsim.settings.run import RunSettings
    from hmrsim.world.model import World


class Sent(NamedTuple):
    """A goal of an episode, and when it was sent."""

    at: float
    command: SendGoal


class Goals:
    """A sink that keeps the goals of a run."""

    def __init__(self) -> None:
        self.sent: list[Sent] = []

    def wants(self, _topic: Topic) -> bool:
        """Return False for all topics."""
        return False

    def emit(self, output: Output) -> None:
        """Ignore the outputs of the simulation."""

    def commanded(self, command: Command, _by: str, now: float) -> None:
        """Record a goal that was sent."""
        if isinstance(command, SendGoal):
            self.sent.append(Sent(now, command._replace(reply_to=None, result_to=None)))

    def repeat(self, world: World, settings: RunSettings, end: float) -> Simulator:
        """Send the same goals at the same times to a new simulator; return it at *end*, in simulated seconds."""
        simulator = Simulator(world, settings, [])
        for sent in self.sent:
            simulator.advance(sent.at)
            simulator.submit(sent.command)
        simulator.advance(end)
        return simulator
