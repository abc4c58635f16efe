"""The cost of traffic policies per driven lane: the same crowd under each policy, in turns.

One crowd executes its scripts in the warehouse. Another one wanders over a grid of single tracks, where one robot in
four meets another head on. Ratios compare the processor time per lane: in the warehouse with robots that pass through
each other, on the grid with simpy's bare loop.
"""

from __future__ import annotations

import gc
import random
import time
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from benchmarks._bare_loop import bare_loop
from benchmarks._fleet import SIDE, Lanes, Wanderers, grid_world, plan_everything, under
from benchmarks._report import Row
from benchmarks._spread import Spread
from benchmarks._timing import Rounds, microseconds
from hmrsim.simulation.simulator import Simulator
from hmrsim.traffic.policies import registry
from hmrsim.world.model import World
from hmrsim.world_checks import load_world

if TYPE_CHECKING:
    import simpy

    from hmrsim.protocol.sinks import Sink

QUICK: dict[str, Any] = {"rounds": 1, "seconds": 100.0}

_MAX_RATIOS = {"reserve": 1.5}
"""To ``free``, in the warehouse."""
_MAX_BARE_RATIOS = {"reserve": 3.0, "priority": 6.0}
"""To the bare loop, on the grid."""
_BARE = "simpy's bare loop"
_MIN_FACTOR = 2000.0
_MAX_SECONDS = 36_000.0


def run(
    rounds: int = 5, seconds: float = 1000.0, robots: int = 100, side: int = SIDE, scripts: str = "warehouse"
) -> list[Row]:
    """Measure both crowds under each policy."""
    return [*_scripts(scripts, rounds), *_grid(rounds, seconds, robots, side)]


def _scripts(name: str, rounds: int) -> list[Row]:
    world = load_world(name).world
    took = _compared(world, rounds, _run_scripts)
    rows = [
        Row(
            f"{name}, a lane under {policy}",
            took.spread(policy, microseconds),
            "µs",
            ratio=None if policy == "free" else took.ratio(policy, to="free"),
            ratio_at_most=_MAX_RATIOS.get(policy),
        )
        for policy in took.taken
    ]
    factors = []
    for _ in range(rounds):
        simulator = Simulator(world)
        began = time.perf_counter()
        simulator.run_scripts(_MAX_SECONDS)
        factors.append(simulator.now / (time.perf_counter() - began))
    title = f"{name} as it is shipped, {len(world.robots)} robots with batteries, under {world.policy}"
    return [*rows, Row(title, Spread.of(factors), "times real time", at_least=_MIN_FACTOR)]


def _grid(rounds: int, seconds: float, robots: int, side: int) -> list[Row]:
    world = grid_world(robots, side=side)
    starts = random.Random(1).sample(sorted(world.waypoints), robots)
    placed = {f"robot_{number}": {"at": start} for number, start in enumerate(starts)}
    plain = world.model_dump(mode="json", by_alias=True, exclude_defaults=True)

    def wander(world: World, sinks: Sequence[Sink]) -> float:
        crowd = Wanderers(world)
        simulator = Simulator(world, sinks=[crowd, *sinks])
        plan_everything(simulator)
        crowd.start(simulator, simulator.robots)
        return _timed(lambda: simulator.advance(seconds))

    bare = bare_loop(robots)
    took = _compared(
        World.model_validate(plain | {"robots": placed}), rounds, wander, {_BARE: lambda: _a_lane(bare, seconds)}
    )
    return [
        Row(
            f"{robots} on a grid, a lane {'of' if name == _BARE else 'under'} {name}",
            took.spread(name, microseconds),
            "µs",
            took.ratio(name, to=_BARE),
            ratio_at_most=_MAX_BARE_RATIOS.get(name),
        )
        for name in took.taken
    ]


def _a_lane(bare: simpy.Environment, seconds: float) -> float:
    """Return the processor seconds of a timeout, over some simulated seconds."""
    scheduled = next(bare._eid)  # noqa: SLF001 - simpy counts its events there
    took = _timed(lambda: bare.run(until=bare.now + seconds))
    return took / (next(bare._eid) - scheduled)  # noqa: SLF001 - simpy's counter


def _run_scripts(world: World, sinks: Sequence[Sink]) -> float:
    simulator = Simulator(world, sinks=sinks)
    return _timed(lambda: simulator.run_scripts(_MAX_SECONDS))


def _timed(run: Callable[[], None]) -> float:
    """Return the processor seconds of a run."""
    gc.collect()
    began = time.process_time()
    run()
    return time.process_time() - began


def _compared(
    world: World,
    rounds: int,
    go: Callable[[World, Sequence[Sink]], float],
    others: Mapping[str, Callable[[], float]] = MappingProxyType({}),
) -> Rounds:
    """Return what a lane costs under each policy, in processor seconds, and what *others* return in turns with them."""
    policies = ["free", *(name for name in registry() if name != "free")]
    worlds = {policy: under(world, policy) for policy in policies}
    lanes = {policy: max(1, _driven(each, go)) for policy, each in worlds.items()}
    taken: dict[str, list[float]] = {name: [] for name in (*others, *policies)}
    for _ in range(rounds):
        for name, other in others.items():
            taken[name].append(other())
        for policy, each in worlds.items():
            taken[policy].append(go(each, ()) / lanes[policy])
    return Rounds(taken)


def _driven(world: World, go: Callable[[World, Sequence[Sink]], float]) -> int:
    lanes = Lanes()
    go(world, [lanes])
    return lanes.driven
