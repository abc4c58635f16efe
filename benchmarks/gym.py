"""Decisions a second of the environments for learning, and what of it the goals take without any client."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import gymnasium

from benchmarks._goals import Goals
from benchmarks._report import Row
from benchmarks._simpy_dispatch import Job, SimpyDispatch
from benchmarks._spread import Spread
from hmrsim.program.memory import collect_rarely
from hmrsim.settings.run import RunSettings
from hmrsim.simulation.simulator import Simulator
from hmrsim_gym import nearest, parallel_env
from hmrsim_gym.dispatching import Dispatching
from hmrsim_gym.observations import Observer
from hmrsim_gym.setting import Setting

QUICK: dict[str, Any] = {"rounds": 2, "horizon": 300.0}


def run(*, rounds: int = 20, horizon: float = 1800.0) -> list[Row]:
    """Return how many decisions a second there are, of the rule to serve the nearest order.

    Args:
        rounds: The number of turns of each variant, each with another seed.
        horizon: Simulated seconds of an episode.
    """
    setting = Setting.of("warehouse_orders", horizon=horizon)
    variants: dict[str, Callable[[int], tuple[int, float]]] = {
        "hmrsim/Dispatch-v0": _One(horizon).run,
        "parallel_env": _Many(horizon).run,
        "the same goals, on a bare simulator": lambda seed: _bare(setting, seed),
        _SIMPY: _Minimal(setting).run,
        "resets": lambda seed: _resets(setting, seed),
    }
    for each in variants.values():
        each(0)
    took: dict[str, list[tuple[int, float]]] = {name: [] for name in variants}
    collect_rarely()
    for seed in range(1, rounds + 1):
        for name, each in variants.items():
            took[name].append(each(seed))
    resets = took.pop("resets")
    rates = {name: [number / seconds for number, seconds in turns] for name, turns in took.items()}
    floor, minimal = rates["the same goals, on a bare simulator"], rates.pop(_SIMPY)
    slower = Spread.of(least / mine for least, mine in zip(minimal, rates["hmrsim/Dispatch-v0"], strict=True))
    return [
        *(
            Row(
                name,
                Spread.of(rate),
                "decisions/s and core",
                Spread.of(mine / its for mine, its in zip(rate, floor, strict=True)),
                at_least=5000.0 if rate is not floor else None,
            )
            for name, rate in rates.items()
        ),
        Row(_SIMPY, Spread.of(minimal), "decisions/s and core", slower, ratio_at_most=30.0),
        Row("a reset", Spread.of(1e3 * seconds / number for number, seconds in resets), "ms of processor time"),
    ]


class _One:
    """Runs episodes of the Gymnasium environment."""

    def __init__(self, horizon: float) -> None:
        self._env = gymnasium.make("hmrsim/Dispatch-v0", world="warehouse_orders", horizon=horizon).unwrapped

    def run(self, seed: int) -> tuple[int, float]:
        """Return how many decisions an episode has, and its processor time."""
        began, number, over = time.process_time(), 0, False
        observation, _ = self._env.reset(seed=seed)
        while not over:
            observation, _, terminated, truncated, _ = self._env.step(nearest(observation))
            number, over = number + 1, terminated or truncated
        return number, time.process_time() - began


class _Many:
    """Runs episodes of the PettingZoo environment."""

    def __init__(self, horizon: float) -> None:
        self._env = parallel_env("warehouse_orders", horizon=horizon)

    def run(self, seed: int) -> tuple[int, float]:
        """Return how many steps an episode has, and its processor time."""
        began, number = time.process_time(), 0
        observations, _ = self._env.reset(seed=seed)
        while self._env.agents:
            observations, *_ = self._env.step({robot: nearest(seen) for robot, seen in observations.items()})
            number += 1
        return number, time.process_time() - began


_SIMPY = "the same orders, in a minimal environment of pure simpy"


class _Minimal:
    """Runs episodes of a minimal environment, with the orders of the worlds' seeds."""

    def __init__(self, setting: Setting) -> None:
        self._setting = setting
        world = setting.world
        self._env = SimpyDispatch([world.point(world.robots[name].at) for name in setting.robots], setting.horizon)

    def run(self, seed: int) -> tuple[int, float]:
        """Return how many decisions an episode has, and its processor time."""
        self._env.give(self._jobs(seed))
        began, number, over = time.process_time(), 0, False
        observation, _ = self._env.reset(seed=seed)
        while not over:
            observation, _, _, over, _ = self._env.step(nearest(observation))
            number += 1
        return number, time.process_time() - began

    def _jobs(self, seed: int) -> list[Job]:
        """Return the orders that arrive, whatever robots do."""
        simulator = Simulator(self._setting.world, RunSettings(seed=seed), [])
        simulator.advance(self._setting.horizon)
        point = self._setting.world.point
        return [Job(order.placed, point(order.at), point(order.to)) for order in simulator.demand.open.values()]


def _bare(setting: Setting, seed: int) -> tuple[int, float]:
    """Return the number of decisions of an episode, and the processor time of its goals without subscribers."""
    goals, decisions = Goals(), 0
    run, observer = Dispatching(setting, seed, [goals]), Observer(setting)
    run.run_on()
    while not run.over:
        robot = run.asking[0]
        run.assign(robot, observer.choices(run, robot)[0])
        decisions += 1
        run.run_on()
    run.close()
    began = time.process_time()
    goals.repeat(setting.world, RunSettings(seed=seed), setting.horizon)
    return decisions, time.process_time() - began


def _resets(setting: Setting, seed: int) -> tuple[int, float]:
    """Return one, and the processor time of an episode that ends at its first decision."""
    began = time.process_time()
    run = Dispatching(setting, seed)
    run.run_on()
    run.close()
    return 1, time.process_time() - began
