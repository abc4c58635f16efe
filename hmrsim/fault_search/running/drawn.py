"""How much of its battery each robot uses without charging: a sink of the run without faults."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.components.battery import BatterySettings
from hmrsim.events.batteries import ChargingBegan, ChargingEnded
from hmrsim.protocol.outputs import EventStamped
from hmrsim.protocol.topics import Topic

if TYPE_CHECKING:
    from hmrsim.protocol.outputs import Output
    from hmrsim.simulation.simulator import Simulator
    from hmrsim.world.model import World


class Drawn:
    """A sink that knows of each battery how far it has fallen from one charge to the next.

    Args:
        simulator: The simulator; it has not started.
        world: Its world.
    """

    def __init__(self, simulator: Simulator, world: World) -> None:
        self._simulator = simulator
        self._charged: dict[str, float] = {}
        self._most: dict[str, float] = {}
        for name, robot in world.robots.items():
            settings = world.robot_type(robot).components.get("battery")
            if settings is not None:
                battery = BatterySettings.model_validate(settings)
                charge = battery.capacity if battery.initial_charge is None else battery.initial_charge
                self._charged[name] = charge / battery.capacity

    def wants(self, topic: Topic) -> bool:
        """Return whether a topic is wanted: events."""
        return topic is Topic.EVENTS

    def emit(self, output: Output) -> None:
        """Note how low a battery is when it begins to charge, and how full it is when that ends."""
        if isinstance(output, EventStamped):
            event = output.event
            if isinstance(event, ChargingBegan):
                self._note(event.robot, event.percentage)
            elif isinstance(event, ChargingEnded):
                self._charged[event.robot] = event.percentage

    def at_the_end(self) -> tuple[tuple[str, float], ...]:
        """Return for each robot with a battery which share of its capacity it has used at most without charging."""
        for name, robot in self._simulator.robots.items():
            if robot.energy is not None:
                self._note(name, robot.energy.battery.share(robot.now))
        return tuple(self._most.items())

    def _note(self, robot: str, share: float) -> None:
        used = self._charged.get(robot, 1.0) - share
        self._most[robot] = max(self._most.get(robot, 0.0), used)
