"""A lane that is driven, against Mesa's agents that only count lanes: pip install mesa, or there are no rows.

Mesa is Python's usual library for agents; its time goes in steps, here of a second. In each step each agent counts the
seconds, and a lane when its time is over; it knows no way, no goal and no other agent.
"""

from __future__ import annotations

import importlib.util
import random
import time
from collections.abc import Callable
from typing import Any

from benchmarks._fleet import LANE_SECONDS, SIDE, Wanderers, grid_world, plan_everything
from benchmarks._report import Row
from benchmarks._timing import Rounds, microseconds
from hmrsim.program.memory import collect_rarely
from hmrsim.settings.run import RunSettings
from hmrsim.simulation.simulator import Simulator

QUICK: dict[str, Any] = {"rounds": 2, "seconds": 200.0}

_COUNTED = "a lane that a Mesa agent counts"
_DRIVEN = "a lane that a robot drives, under free"


def run(*, robots: int = 100, rounds: int = 11, seconds: float = 2000.0, side: int = SIDE) -> list[Row]:
    """Return what both cost in turns, in processor time.

    Args:
        robots: And agents.
        rounds: How many.
        seconds: Simulated seconds of a round, of both.
        side: Waypoints along each side of the grid.
    """
    if importlib.util.find_spec("mesa") is None:
        return []
    world = grid_world(robots, side=side)
    crowd = Wanderers(world)
    simulator = Simulator(world, RunSettings(keep_results=10), [crowd])
    plan_everything(simulator)
    crowd.start(simulator, simulator.robots)
    simulator.run(until=seconds)
    collect_rarely()
    step, lanes = _counting(robots), robots * seconds / LANE_SECONDS
    taken: dict[str, list[float]] = {_COUNTED: [], _DRIVEN: []}
    for _ in range(rounds):
        taken[_COUNTED].append(_timed(lambda: [step() for _ in range(round(seconds))]) / lanes)
        taken[_DRIVEN].append(_timed(lambda: simulator.run(until=simulator.now + seconds)) / lanes)
    took = Rounds(taken)
    name = f"{robots:,} robots"
    return [
        Row(f"{name}: {_COUNTED}", took.spread(_COUNTED, microseconds), "µs", 1.0),
        Row(
            f"{name}: {_DRIVEN}",
            took.spread(_DRIVEN, microseconds),
            "µs",
            took.ratio(_DRIVEN, to=_COUNTED),
            ratio_at_most=1.0,
        ),
    ]


def _counting(agents: int) -> Callable[[], object]:
    """Return what makes a step of a second with agents that count lanes."""
    chance = random.Random(1)
    mesa = importlib.import_module("mesa")

    class Counter(mesa.Agent):  # type: ignore[name-defined,misc]
        def __init__(self, model: Any) -> None:
            super().__init__(model)
            self.lanes = 0
            self.left = chance.uniform(0.0, LANE_SECONDS)

        def step(self) -> None:
            self.left -= 1.0
            if self.left <= 0.0:
                self.lanes += 1
                self.left += chance.uniform(0.6, 1.4) * LANE_SECONDS

    model = mesa.Model(seed=1)
    for _ in range(agents):
        Counter(model)
    return lambda: model.agents.shuffle_do("step")


def _timed(run: Callable[[], object]) -> float:
    began = time.process_time()
    run()
    return time.process_time() - began
