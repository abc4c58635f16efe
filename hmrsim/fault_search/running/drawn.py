"""How much of its battery each robot uses: a sink of the run without faults."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from hmrsim.events.robots import ChargingBegan, ChargingEnded
from hmrsim.fault_search.space.energy import Draw, battery_of, share_at_start
from hmrsim.protocol.goal import GoalStatus
from hmrsim.protocol.outputs import EventStamped, GoalChanged
from hmrsim.protocol.topics import Topic

if TYPE_CHECKING:
    from hmrsim.protocol.outputs import Output
    from hmrsim.simulation.simulator import Simulator
    from hmrsim.world.model import World


class Drawn:
    """A sink that knows how far each battery falls.

    Args:
        simulator: The simulator; it has not started.
        world: Its world.
    """

    def __init__(self, simulator: Simulator, world: World) -> None:
        self._simulator = simulator
        batteries = ((name, battery_of(world, name)) for name in world.robots)
        self._charged = {name: share_at_start(battery) for name, battery in batteries if battery is not None}
        self._begun: dict[str, tuple[str, float]] = {}
        self._draws: dict[str, Draw] = {}

    def wants(self, topic: Topic) -> bool:
        """Return whether a topic is wanted: events."""
        return topic is Topic.EVENTS

    def taker(self, kind: type) -> Callable[[Any], object] | None:
        """Return what takes outputs of a type."""
        return self.emit if kind in (EventStamped, GoalChanged) else None

    def emit(self, output: Output) -> None:
        """Note how full a battery is when a goal or charging begins and ends."""
        if isinstance(output, GoalChanged):
            self._note_goal(output)
        elif isinstance(output, EventStamped):
            event = output.event
            if isinstance(event, ChargingBegan):
                self._note(event.robot, event.percentage)
            elif isinstance(event, ChargingEnded):
                self._charged[event.robot] = event.percentage

    def at_the_end(self) -> tuple[tuple[str, Draw], ...]:
        """Return what each robot with a battery has taken from it at most."""
        for name in self._charged:
            self._note(name, self._share(name))
        return tuple(self._draws.items())

    def _note_goal(self, change: GoalChanged) -> None:
        if change.robot not in self._charged:
            return
        share = self._share(change.robot)
        if change.status is GoalStatus.EXECUTING:
            self._begun[change.goal_id] = change.robot, share
        elif change.status.terminal and change.goal_id in self._begun:
            robot, before = self._begun.pop(change.goal_id)
            draw = self._draws.get(robot, Draw())
            self._draws[robot] = draw._replace(goal=max(draw.goal, before - share))

    def _share(self, name: str) -> float:
        robot = self._simulator.robots.get(name)
        return 0.0 if robot is None or robot.energy is None else robot.energy.battery.share(robot.now)

    def _note(self, robot: str, share: float) -> None:
        draw = self._draws.get(robot, Draw())
        self._draws[robot] = draw._replace(whole=max(draw.whole, self._charged.get(robot, 1.0) - share))
