"""Watching a simulation for a report: a sink that hears what a page would, and reads batteries besides."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from hmrsim.engine.sim_time import stamp
from hmrsim.protocol.gateway import WATCHED, GoalChanged, Happened, Topic
from hmrsim.report.occurrence import Occurrence
from hmrsim.simulation.snapshot import scene

if TYPE_CHECKING:
    from collections.abc import Callable

    from hmrsim.protocol.gateway import Command, Event
    from hmrsim.simulation.simulator import Simulator

_ANEW: Final = ("reset", "world_loaded")


class Watcher:
    """A sink that tells what happens, and begins with what there is.

    Args:
        simulator: Whom to watch; it has not begun.
        take: Told each occurrence, in order.
    """

    def __init__(self, simulator: Simulator, take: Callable[[Occurrence], object]) -> None:
        self._simulator = simulator
        self._take = take
        self._record = simulator.record
        self._see()
        simulator.record = self._commanded
        simulator.attach(self)

    def wants(self, topic: Topic) -> bool:
        """Return whether it listens to a topic: to what happens, and to how robots move."""
        return topic in (Topic.EVENTS, Topic.MOTION)

    def emit(self, event: Event) -> None:
        """Tell what happened."""
        if isinstance(event, Happened):
            if event.kind == "route":
                return
            self._take(Occurrence(*event))
            if event.kind in _ANEW:
                self._see()
            # In between the charge falls, or rises, and never both.
            robot = event.fields.get("robot")
            if isinstance(robot, str) and event.kind not in WATCHED:
                self._weigh(robot)
        elif isinstance(event, GoalChanged):
            result = (
                event.result.model_dump(mode="json") if event.result is not None and event.status >= _FAILED else None
            )
            self._take(Occurrence(event.stamp, "status", {**event._asdict(), "goal": None, "result": result}))
            if event.status.terminal:
                self._weigh(event.robot)

    def weigh_all(self) -> None:
        """Tell what is in all batteries."""
        for robot in self._simulator.robots:
            self._weigh(robot)

    def _commanded(self, command: Command, by: str) -> None:
        """Tell the time: what is asked for may be that it begins anew."""
        self._record(command, by)
        self._take(Occurrence(stamp(self._simulator.now), "commanded", {}))

    def _see(self) -> None:
        self._take(Occurrence(stamp(self._simulator.now), "scene", scene(self._simulator)))
        self.weigh_all()

    def _weigh(self, name: str) -> None:
        robot = self._simulator.robots.get(name)
        if robot is None or robot.energy is None:
            return
        battery, now = robot.energy.battery, robot.now
        said = {"robot": name, "charge": battery.charge(now), "percentage": battery.share(now)}
        self._take(Occurrence(stamp(now), "battery", said))


_FAILED: Final = 5
"""The first status of a goal of which the result says what went wrong."""
