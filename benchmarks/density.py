"""Dense fleets: arrivals, lost goals, waits, deadlocks and speed under each policy, on a lattice of single tracks.

Each robot gets a new random goal when it has arrived; a goal that fails is lost. The ratio is to robots that pass
through each other: of arrivals, and of simulated seconds a processor second.
"""

from __future__ import annotations

import gc
import itertools
import random
import time
from typing import TYPE_CHECKING, Any, NamedTuple

from benchmarks._fleet import Wanderers
from benchmarks._report import Row
from hmrsim.events.traffic import Deadlock
from hmrsim.protocol.goal import GoalStatus
from hmrsim.protocol.outputs import EventStamped, GoalChanged
from hmrsim.protocol.topics import Topic
from hmrsim.simulation.simulator import Simulator
from hmrsim.traffic.policies import registry
from hmrsim.world.model import World

if TYPE_CHECKING:
    from hmrsim.protocol.outputs import Output

QUICK: dict[str, Any] = {"crowds": ((20, 60.0),), "side": 8}

_LANE = 1.0
_MINUTE = 60.0
_SLICE = 1.0
"""Simulated seconds after which it is counted who waits, and looked whether the processor time is used up."""


class _Seen:
    """A sink that counts deadlocks, and how goals to drive somewhere end."""

    def __init__(self) -> None:
        self.arrived = self.lost = self.deadlocks = 0

    def emit(self, output: Output) -> None:
        """Count a goal that has ended, or a deadlock."""
        if isinstance(output, EventStamped):
            self.deadlocks += isinstance(output.event, Deadlock)
        elif isinstance(output, GoalChanged) and output.status.terminal and output.action == "navigate_to_pose":
            self.arrived += output.status is GoalStatus.SUCCEEDED
            self.lost += output.status is not GoalStatus.SUCCEEDED

    def wants(self, topic: Topic) -> bool:
        """Return whether it takes a topic; ends of goals come unasked."""
        return topic is Topic.EVENTS


class _Measured(NamedTuple):
    """What came of a crowd.

    Attributes:
        arrivals: A robot-minute.
        lost: The share of goals that failed.
        waiting: The share of their time for which robots have waited.
        deadlocks: A simulated minute.
        factor: Simulated seconds a processor second.
    """

    arrivals: float
    lost: float
    waiting: float
    deadlocks: float
    factor: float


def run(
    crowds: tuple[tuple[int, float], ...] = ((100, 300.0), (500, 60.0)), side: int = 25, most: float = 120.0
) -> list[Row]:
    """Measure crowds of some robots, each for some simulated seconds, on a lattice of *side* times *side* waypoints.

    A policy that needs more than *most* processor seconds is measured for a shorter simulated time.
    """
    rows: list[Row] = []
    policies = ["free", *(name for name in registry() if name != "free")]
    for robots, seconds in crowds:
        found = {policy: _measured(_lattice(robots, side, policy), seconds, most) for policy in policies}
        free = found["free"]
        for policy, seen in found.items():
            name = f"{robots} robots on {side * side} waypoints, {policy}"
            rows += [
                Row(f"{name}: arrivals", seen.arrivals, "a robot-minute", ratio=seen.arrivals / free.arrivals),
                Row(f"{name}: lost goals", 100.0 * seen.lost, "% of goals"),
                Row(f"{name}: waiting", 100.0 * seen.waiting, "% of the time"),
                Row(f"{name}: deadlocks", seen.deadlocks, "a minute"),
                Row(f"{name}: speed", seen.factor, "times real time", ratio=seen.factor / free.factor),
            ]
    return rows


def _lattice(robots: int, side: int, policy: str) -> World:
    chance = random.Random(1)
    points = {f"w{x:02}{y:02}": [_LANE * x, _LANE * y] for x, y in itertools.product(range(side), repeat=2)}
    across = [[f"w{x:02}{y:02}" for x in range(side)] for y in range(side)]
    lines = [*across, *zip(*across, strict=True)]
    starts = chance.sample(sorted(points), robots)
    return World.model_validate(
        {
            "name": f"{robots} robots on a lattice",
            "waypoints": points,
            "lanes": [pair for line in lines for pair in itertools.pairwise(line)],
            "robots": {f"robot_{number}": {"at": start} for number, start in enumerate(starts)},
            "traffic": {"policy": policy, "patience": None},
        }
    )


def _measured(world: World, seconds: float, most: float) -> _Measured:
    """Let a crowd wander for some simulated seconds, or until *most* processor seconds are over."""
    crowd, seen = Wanderers(world), _Seen()
    simulator = Simulator(world, sinks=[crowd, seen])
    for point in world.points.values():
        simulator.graph.find_ways(point, 1.0)
    crowd.start(simulator, simulator.robots)
    gc.collect()
    took, waiting, slices = 0.0, 0, 0
    while simulator.now < seconds and took < most:
        began = time.process_time()
        simulator.advance(min(seconds, simulator.now + _SLICE))
        took += time.process_time() - began
        waiting += sum(robot.waits for robot in simulator.robots.values())
        slices += 1
    minutes = simulator.now / _MINUTE
    return _Measured(
        seen.arrived / len(world.robots) / minutes,
        seen.lost / max(1, seen.arrived + seen.lost),
        waiting / len(world.robots) / slices,
        seen.deadlocks / minutes,
        simulator.now / took,
    )
