"""The hospital's mission within one process: runs a second and core, of a process that has run it before."""

from __future__ import annotations

import statistics
import tempfile
import time
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

from benchmarks import _mission
from benchmarks._goals import Goals
from benchmarks._report import Row
from benchmarks._spread import Spread
from hmrsim.experiments.reading import read_plan
from hmrsim.experiments.replications import execute_run
from hmrsim.program.memory import collect_rarely, collect_run
from hmrsim.settings.run import RunSettings
from hmrsim.testing import simulation
from hmrsim.world.model import Base
from hmrsim.world_checks import load_world

if TYPE_CHECKING:
    from hmrsim.testing import Run
    from hmrsim.world.model import World

QUICK: dict[str, Any] = {"rounds": 3, "runs": 3, "missions": 1}

_TREE = "bt_controller.examples.hospital:mission"
_STUDY = f"""\
name: mission
world: hospital
treatments: {{all: {{tree: "{_TREE}"}}}}
measures: {{time: end.at}}
"""
_SPEED = 1.2
"""Meters a second, of which each run's robots have a little more than those of the run before."""


def run(*, rounds: int = 20, runs: int = 10, missions: int = 3) -> list[Row]:
    """Return how many runs a second each variant makes; they take turns.

    Args:
        rounds: How often each variant has its turn.
        runs: Of the mission in a turn.
        missions: How often it is run over Zenoh.
    """
    world = load_world("hospital").world
    worker = _Worker()
    with ExitStack() as stack:
        again = _Again(stack.enter_context(simulation(world, tree=_TREE)))
        others = _Others(world)
        variants: dict[str, Callable[[], object]] = {
            "the same world": lambda: _whole(world),
            "robots of other speeds in each run": lambda: _whole(others.following()),
            "a reset in between": again.run,
            _WORKER: worker.run,
            _BARE: worker.repeat,
        }
        for make in variants.values():
            make()
        took: dict[str, list[float]] = {name: [] for name in variants}
        collect_rarely()
        for _ in range(rounds):
            for name, make in variants.items():
                took[name].append(_seconds(make, runs))
    beside = _beside(missions)
    of_worker, bare = took.pop(_WORKER), took.pop(_BARE)
    ratio = Spread.of(run / alone for run, alone in zip(of_worker, bare, strict=True))
    return [
        *(row for name, seconds in took.items() for row in _rows(name, seconds, beside)),
        Row(_WORKER, Spread.of(1e3 * each for each in of_worker), "ms of processor time", ratio, ratio_at_most=2.0),
        Row(_BARE, Spread.of(1e3 * each for each in bare), "ms of processor time", 1.0),
        Row("over Zenoh in lockstep: a run", 1e3 * beside, "ms of wall time", 1.0),
    ]


def _rows(name: str, seconds: list[float], beside: float) -> list[Row]:
    """Return how many runs a second and core a variant makes, and what one takes, against one over Zenoh."""
    each, ratio = (Spread.of(value / unit for value in seconds) for unit in (1e-3, beside))
    return [
        Row(name, Spread.of(1.0 / value for value in seconds), "runs/s and core", at_least=60.0),
        Row(f"{name}: a run", each, "ms of processor time", ratio),
    ]


def _seconds(make: Callable[[], object], runs: int) -> float:
    """Return the processor time of a run."""
    began = time.process_time()
    for _ in range(runs):
        make()
    return (time.process_time() - began) / runs


def _whole(world: World) -> Run:
    """Run the mission from nothing but a world."""
    with simulation(world, tree=_TREE) as whole:
        whole.to_the_end()
    return whole


class _Others:
    """Worlds with one map, whose robots differ from one to the next."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._made = 0

    def following(self) -> World:
        """Return the next world."""
        self._made += 1
        base = Base(speed=_SPEED + self._made / 10_000)
        robots = {name: robot.model_copy(update={"base": base}) for name, robot in self._world.robots.items()}
        return self._world.model_copy(update={"robots": robots})


_WORKER = "a run of an experiment, in a warm worker"
_BARE = "the same goals, without controller and client"


class _Worker:
    """The mission in a worker of an experiment, and its goals without controller and client."""

    def __init__(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "mission.yaml")
            path.write_text(_STUDY, encoding="utf-8")
            self._plan = read_plan(path)
        self._run = self._plan.run(0, "all", 0)
        self._goals = Goals()
        row = execute_run(self._plan, self._run, lambda _simulator, _pacing: [self._goals])
        if row.ending != "succeeded" or row.at is None:
            raise AssertionError(row.cause)
        self._end = row.at

    def run(self) -> None:
        """Run the mission."""
        execute_run(self._plan, self._run)

    def repeat(self) -> None:
        """Send the goals of the run again, without its controller."""
        world, settings = self._plan.world(0).world, RunSettings(seed=self._run.seed)
        self._goals.repeat(world, settings, self._end)
        collect_run()


class _Again:
    """One simulation, which is reset before each further run."""

    def __init__(self, first: Run) -> None:
        self._run = first
        self._run.to_the_end()

    def run(self) -> Run:
        """Reset it, and run the mission."""
        client = self._run.client
        client.get(client.keys.world("reset_simulation"), payload=b"{}")
        self._run.to_the_end()
        return self._run


def _beside(missions: int) -> float:
    """Return the wall seconds that the mission takes over Zenoh, between separate processes."""
    return statistics.median(_mission.in_lockstep().wall for _ in range(missions))
