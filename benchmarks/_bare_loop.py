"""The baseline of simulations: bare simpy with as many processes, each of which waits for the duration of a lane."""

from __future__ import annotations

import random
from collections.abc import Generator
from typing import Any

import simpy

from benchmarks._fleet import LANE_SECONDS

_SETTLED = 2.0
"""Simulated seconds after which all are at different places of their lanes."""


def bare_loop(robots: int) -> simpy.Environment:
    """Return an environment of processes that do nothing but one timeout a lane."""
    env, chance = simpy.Environment(), random.Random(1)

    def lanes() -> Generator[simpy.Event, Any, None]:
        while True:
            yield env.timeout(chance.uniform(0.6, 1.4) * LANE_SECONDS)

    for _ in range(robots):
        env.process(lanes())
    env.run(until=_SETTLED)
    return env
