"""Dense fleets: arrivals, lost goals, waits, deadlocks and cost under each policy, on three kinds of worlds.

Each robot gets a new random goal when it has arrived; a goal that fails is lost. The ratio is to robots that pass
through each other: of arrivals, and of simulated seconds a processor second.
"""

from __future__ import annotations

import gc
import itertools
import random
import tempfile
import time
from collections.abc import Collection
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from benchmarks._fleet import Lanes, Wanderers, under
from benchmarks._report import Row
from hmrsim.events.traffic import Deadlock
from hmrsim.protocol.goal import GoalStatus
from hmrsim.protocol.outputs import EventStamped, GoalChanged
from hmrsim.protocol.topics import Topic
from hmrsim.simulation.simulator import Simulator
from hmrsim.traffic.policies import registry
from hmrsim.world.model import World
from hmrsim.world_checks import load_world

if TYPE_CHECKING:
    from hmrsim.geometry import Point
    from hmrsim.protocol.outputs import Output
    from hmrsim.protocol.sinks import Sink

QUICK: dict[str, Any] = {
    "crowds": ((20, 60.0),),
    "side": 8,
    "racks": 2,
    "pickers": ((10, 60.0),),
    "shipped": (("warehouse", 10.0),),
}

_LANE = 1.0
_MINUTE = 60.0
_GOALS = 200
"""Among racks; a table of the ways to each is made before the measurement."""
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
    """The results of a crowd.

    Attributes:
        arrivals: A robot-minute.
        lost: The share of goals that failed.
        waiting: The share of their time for which robots have waited.
        deadlocks: A simulated minute.
        factor: Simulated seconds a processor second.
        lane: Processor time a lane driven, in microseconds.
    """

    arrivals: float
    lost: float
    waiting: float
    deadlocks: float
    factor: float
    lane: float


def run(
    crowds: tuple[tuple[int, float], ...] = ((100, 300.0), (500, 60.0)),
    side: int = 25,
    racks: int = 10,
    pickers: tuple[tuple[int, float], ...] = ((100, 300.0), (400, 120.0)),
    shipped: tuple[tuple[str, float], ...] = (("warehouse", 300.0),),
    most: float = 120.0,
) -> list[Row]:
    """Measure crowds of some robots, each for some simulated seconds.

    They are on a lattice of *side* times *side* waypoints; on a Moving AI map with *racks* times twice as many racks;
    and in *shipped* worlds. A policy that needs more than *most* processor seconds is measured for a shorter
    simulated time.
    """
    rows: list[Row] = []
    for robots, seconds in crowds:
        lattice = _lattice(robots, side)
        rows += _compare(f"{robots} robots on {side * side} waypoints", lattice, lattice.points.values(), seconds, most)
    for robots, seconds in pickers:
        world, cells, goals = _hall_of_racks(robots, racks)
        rows += _compare(f"{robots} robots among racks, {cells:,} cells", world, goals, seconds, most)
    for name, seconds in shipped:
        world = _shipped(name)
        crowd = f"the shipped {name}, {len(world.robots)} robots"
        rows += _compare(crowd, world, world.points.values(), seconds, most)
    return rows


def _compare(name: str, world: World, goals: Collection[Point], seconds: float, most: float) -> list[Row]:
    """Measure one crowd under each policy."""
    rows: list[Row] = []
    policies = ["free", *(policy for policy in registry() if policy != "free")]
    found = {policy: _measured(under(world, policy), goals, seconds, most) for policy in policies}
    free = found["free"]
    for policy, seen in found.items():
        what = f"{name}, {policy}"
        rows += [
            Row(f"{what}: arrivals", seen.arrivals, "a robot-minute", ratio=seen.arrivals / free.arrivals),
            Row(f"{what}: lost goals", 100.0 * seen.lost, "% of goals"),
            Row(f"{what}: waiting", 100.0 * seen.waiting, "% of the time"),
            Row(f"{what}: deadlocks", seen.deadlocks, "a minute"),
            Row(f"{what}: speed", seen.factor, "times real time", ratio=seen.factor / free.factor),
            Row(f"{what}: a lane", seen.lane, "us", ratio=seen.lane / free.lane),
        ]
    return rows


def _lattice(robots: int, side: int) -> World:
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
        }
    )


def _hall_of_racks(robots: int, racks: int) -> tuple[World, int, list[Point]]:
    """Return a hall drawn as a Moving AI map, as its warehouses are; how many cells are free; and where robots go to.

    Racks of 10 x 2 cells stand in *racks* columns and twice as many rows, a cell apart; before and behind them are
    stations, where the robots start. They go to random ones of these, and of the cells beside the racks.
    """
    edge, length, deep = 12, 10, 2
    width, height = racks * (length + 1) - 1, 2 * racks * (deep + 1) + 1
    columns = [0 <= x < width and x % (length + 1) < length for x in range(-edge, width + edge)]
    lines = ["".join("@" if y % (deep + 1) and column else "." for column in columns) for y in range(height)]
    text = "\n".join(["type octile", f"height {height}", f"width {len(columns)}", "map", *lines, ""])
    free = [(x, y) for y, line in enumerate(lines) for x, cell in enumerate(line) if cell == "."]
    chance = random.Random(1)
    starts = chance.sample([(x, y) for x, y in free if min(x, len(columns) - 1 - x) < edge - 1], robots)
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "hall.map").write_text(text)
        there = "".join(f"  robot_{number}: {{at: {x}_{y}}}\n" for number, (x, y) in enumerate(starts))
        hall = Path(folder, "hall.yaml")
        hall.write_text(f"include: [hall.map]\nrobots:\n{there}")
        world = load_world(str(hall)).world
    names = [f"{x}_{y}" for x, y in chance.sample(free, min(_GOALS, len(free)))]
    return world, len(free), [world.points[name] for name in names]


def _shipped(name: str) -> World:
    """Return a shipped world whose robots have neither scripts nor batteries."""
    world = load_world(name).world
    robots = {name: robot.model_copy(update={"script": (), "components": {}}) for name, robot in world.robots.items()}
    types = {name: kind.model_copy(update={"components": {}}) for name, kind in world.robot_types.items()}
    return world.model_copy(update={"robots": robots, "robot_types": types})


def _measured(world: World, goals: Collection[Point], seconds: float, most: float) -> _Measured:
    """Measure a crowd that wanders for some simulated seconds, or for at most *most* processor seconds.

    A second run counts the lanes, because counting takes time.
    """
    seen = _Seen()
    simulator = _sent_off(world, goals, seen)
    took, waiting, slices = 0.0, 0, 0
    while simulator.now < seconds and took < most:
        began = time.process_time()
        simulator.advance(min(seconds, simulator.now + _SLICE))
        took += time.process_time() - began
        waiting += sum(robot.waits for robot in simulator.robots.values())
        slices += 1
    minutes, lanes = simulator.now / _MINUTE, Lanes()
    _sent_off(world, goals, lanes).advance(simulator.now)
    return _Measured(
        seen.arrived / len(world.robots) / minutes,
        seen.lost / max(1, seen.arrived + seen.lost),
        waiting / len(world.robots) / slices,
        seen.deadlocks / minutes,
        minutes * _MINUTE / took,
        1e6 * took / max(1, lanes.driven),
    )


def _sent_off(world: World, goals: Collection[Point], sink: Sink) -> Simulator:
    """Return a simulator whose crowd has started and whose routes are planned."""
    crowd = Wanderers(world, points=goals)
    simulator = Simulator(world, sinks=[crowd, sink])
    for point in goals:
        simulator.graph.find_ways(point, 1.0)
    crowd.start(simulator, simulator.robots)
    gc.collect()
    return simulator
