"""A large fleet where all have room: how fast it runs under each policy, with 32 robots a lane and a waypoint.

Nobody waits for long, so that it shows what the asking itself costs. The ratio is to robots that pass through each
other.
"""

from __future__ import annotations

import time
from typing import Any

from benchmarks._fleet import SIDE, Wanderers, grid_world, plan_everything
from benchmarks._report import Row
from benchmarks._timing import Rounds
from hmrsim.program.memory import collect_rarely
from hmrsim.settings.run import RunSettings
from hmrsim.simulation.simulator import Simulator
from hmrsim.traffic.policies import registry
from hmrsim.world.model import World

QUICK: dict[str, Any] = {"robots": 1000, "seconds": 1.0, "filling": 5.0}

_ROOM = 32
_TARGETS = {"free": 20.0, "reserve": 5.0, "priority": 2.0}
_FILLED = 100.0
"""Simulated seconds until the first trips have ended, and robots are where they meet most."""
_SLICE = 0.01
"""Simulated seconds after which it is looked whether the time of a round is over."""


def run(
    *, robots: int = 10_000, rounds: int = 3, seconds: float = 10.0, filling: float = 60.0, side: int = SIDE
) -> list[Row]:
    """Return how much faster than real time a fleet runs under each policy.

    Args:
        robots: How many.
        rounds: In which the policies take turns.
        seconds: Processor seconds of a policy in a round.
        filling: Those at most in which each fills the grid before; a slow one is measured when it is emptier.
        side: Waypoints along each side of the grid.
    """
    plain = grid_world(robots, side=side)
    policies = ["free", *(name for name in registry() if name != "free")]
    simulators = {policy: _driving(plain, policy, filling) for policy in policies}
    collect_rarely()
    taken: dict[str, list[float]] = {policy: [] for policy in policies}
    for _ in range(rounds):
        for policy, simulator in simulators.items():
            taken[policy].append(_pace(simulator, seconds))
    took = Rounds(taken)
    return [
        Row(
            f"{robots:,} robots with room for all, under {policy}",
            took.spread(policy, lambda pace: 1 / pace),
            "times real time",
            took.ratio(policy, to="free"),
            at_least=_TARGETS.get(policy),
        )
        for policy in policies
    ]


def _driving(world: World, policy: str, filling: float) -> Simulator:
    """Return a simulator of the world under a policy, of whose robots all drive."""
    room = {"waypoint_capacity": _ROOM, "lane_capacity": _ROOM, "patience": None} if policy != "free" else {}
    plain = world.model_dump(mode="json", by_alias=True, exclude_defaults=True)
    crowded = World.model_validate(plain | {"traffic": {"policy": policy, **room}})
    crowd = Wanderers(crowded)
    simulator = Simulator(crowded, RunSettings(keep_results=10), [crowd])
    plan_everything(simulator)
    crowd.start(simulator, simulator.robots)
    began = time.process_time()
    while simulator.now < _FILLED and time.process_time() - began < filling:
        simulator.advance(simulator.now + 1.0)
    return simulator


def _pace(simulator: Simulator, seconds: float) -> float:
    """Return the processor seconds of a simulated second, over a round."""
    since, began = simulator.now, time.process_time()
    while (took := time.process_time() - began) < seconds or simulator.now == since:
        simulator.advance(simulator.now + _SLICE)
    return took / (simulator.now - since)
