"""The speed of simulations with many driving robots and no subscriber, in simulated seconds per wall second.

The ratio compares with bare simpy: the same number of processes, which only wait for the ends of lanes.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from benchmarks._bare_loop import bare_loop
from benchmarks._fleet import LANE_SECONDS, SIDE, Wanderers, grid_world, plan_everything
from benchmarks._processes import child, memory
from benchmarks._report import Row
from benchmarks._spread import Spread
from hmrsim.program.memory import collect_rarely
from hmrsim.settings.run import RunSettings
from hmrsim.simulation.simulator import Simulator

if TYPE_CHECKING:
    from multiprocessing.connection import Connection

    import simpy

    from hmrsim.navigation.route import Route

QUICK: dict[str, Any] = {"sizes": (1, 10, 100, 1000), "window": 0.3}

_TARGETS = {100: 10_000.0, 1000: 1000.0, 10_000: 40.0}
_RATIOS = {100: 0.7, 1000: 0.8, 10_000: 0.8}
_EVENTS_A_LOOK = 1000
_SLICES = 8
"""Into which the window is cut, so that the simulator and bare simpy take turns."""
_MIN_FOR_MEMORY = 10_000
"""Robots from which on the memory of the rest does not count."""


@dataclass(frozen=True)
class _Speed:
    """Simulated seconds and events a wall second."""

    factor: float
    events: float


@dataclass(frozen=True)
class _Found:
    """The results for one number of robots.

    Attributes:
        factor: Simulated seconds a wall second.
        events: Events a wall second.
        bare: How much faster simpy alone is.
        planning: Share of the time that is spent in planning.
        searching: Wall seconds of the first search of routes to one waypoint from all others.
        megabytes: Resident memory of the robots, without that of the graph.
    """

    factor: Spread
    events: Spread
    bare: Spread
    planning: float
    searching: float
    megabytes: float


def run(
    *, sizes: Sequence[int] = (1, 10, 100, 1000, 10_000, 100_000), window: float = 4.0, side: int = SIDE
) -> list[Row]:
    """Return rows for each number of robots, each measured in a fresh process for *window* wall seconds."""
    rows: list[Row] = []
    for robots in sizes:
        with child(_measure, robots, window, side) as process:
            found: _Found = process.receive()
        name = f"{robots:,} robot{'s' * (robots > 1)}"
        target = _TARGETS.get(robots)
        rows += [
            Row(name, found.factor, "simulated s/s", found.bare, at_least=target, ratio_at_most=_RATIOS.get(robots)),
            Row(f"{name}: events", found.events, "events/s"),
            Row(f"{name}: planning", found.planning * 100, "% of the time"),
        ]
        if robots >= _MIN_FOR_MEMORY:
            rows.append(Row(f"{name}: memory while they drive", found.megabytes * 1000 / robots, "MB/1,000 robots"))
    return [*rows, Row(f"search for the ways to one of {side * side:,} waypoints", found.searching * 1e3, "ms")]


def _measure(pipe: Connection, robots: int, window: float, side: int) -> None:
    """Send what this size gives."""
    empty = _resident()
    world = grid_world(robots, side=side)
    crowd = Wanderers(world)
    simulator = Simulator(world, RunSettings(keep_results=10), [crowd])
    unplanned, began = _resident(), time.perf_counter()
    plan_everything(simulator)
    searching = (time.perf_counter() - began) / len(simulator.world.waypoints)
    empty += _resident() - unplanned
    crowd.start(simulator, simulator.robots)
    collect_rarely()
    # All begin within the first second: a rush that comes never again.
    simulator.run(until=2.0)
    megabytes = _resident() - empty
    bare = bare_loop(robots)
    whole, floor = [], []
    for _ in range(_SLICES):
        whole.append(_speed(simulator.env, simulator.run, robots, window / _SLICES))
        floor.append(_speed(bare, bare.run, robots, window / _SLICES))
    planning = _planning_share(simulator, robots, window / 2)
    factor = Spread.of(speed.factor for speed in whole)
    events = Spread.of(speed.events for speed in whole)
    ratio = Spread.of(alone.factor / speed.factor for alone, speed in zip(floor, whole, strict=True))
    pipe.send(_Found(factor, events, ratio, planning, searching, megabytes))


def _speed(env: simpy.Environment, run_until: Callable[[float], None], robots: int, window: float) -> _Speed:
    """Run for *window* wall seconds, and a little more: the wall clock is read once in some thousand events."""
    chunk = _EVENTS_A_LOOK * LANE_SECONDS / robots
    scheduled, since = next(env._eid), env.now  # noqa: SLF001 - simpy counts its events there
    began = time.perf_counter()
    while (took := time.perf_counter() - began) < window:
        run_until(env.now + chunk)
    return _Speed((env.now - since) / took, (next(env._eid) - scheduled) / took)  # noqa: SLF001 - simpy's counter


def _planning_share(simulator: Simulator, robots: int, window: float) -> float:
    """Return the share of the wall time that is spent in planning, by a run in which each plan is timed."""
    plan, spent = simulator.graph.plan, 0.0

    def timed(*args: Any) -> Route:
        nonlocal spent
        began = time.perf_counter()
        try:
            return plan(*args)
        finally:
            spent += time.perf_counter() - began

    simulator.graph.plan = timed  # type: ignore[method-assign,assignment]
    began = time.perf_counter()
    _speed(simulator.env, simulator.run, robots, window)
    return spent / (time.perf_counter() - began)


def _resident() -> float:
    return memory("self")[0]
