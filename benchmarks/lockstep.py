"""Controllers that take part in simulated time: how fast a run is, and what a trace costs."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from benchmarks import _mission
from benchmarks._fleet import SIDE, Wanderers, grid_world, plan_everything
from benchmarks._null_controller import NullController
from benchmarks._report import Row
from benchmarks._spread import Spread
from benchmarks._timing import Rounds, Variant, interleaved
from benchmarks._wire import BARE, BARE_PAYLOAD, ask, served
from hmrsim.cli.replay import TraceFile
from hmrsim.program.memory import collect_rarely
from hmrsim.settings.run import RunSettings
from hmrsim.simulation.simulator import Simulator
from hmrsim.world_checks import load_world

if TYPE_CHECKING:
    from hmrsim.world.model import World

QUICK: dict[str, Any] = {"rounds": 20, "missions": 1}

_SETTINGS = RunSettings(clock="lockstep", keep_results=10, participant_timeout=60.0)
_SPEEDS = {100: 1000.0, 1000: 400.0}
_QUANTUM = 1.0
"""Simulated seconds whose results are taken together: a robot is idle for half of that after each goal, on average."""
_DEAREST = {100: 1.8}
"""Where the simulator has little to do in a round trip: with ten times as many robots it has ten times as much."""
_AS_LARGE = {100: 2.0}
"""As above, against a bare query with as many bytes, whose JSON the client writes and reads, too."""
_ROUND_TRIPS = 20
"""Of which one measurement consists."""


def run(
    *,
    sizes: Sequence[int] = (100, 1000),
    rounds: int = 200,
    missions: int = 5,
    factor: float = 10.0,
    side: int = SIDE,
    scripts: str = "warehouse",
) -> list[Row]:
    """Return speeds, and what a trace adds."""
    rows: list[Row] = []
    with tempfile.TemporaryDirectory() as folder:
        for robots in sizes:
            rows += _null_controller(grid_world(robots, side=side), rounds, Path(folder))
        rows += _hospital(missions, factor, rows[0].value / 1e6)
        # Each takes as long as hundreds of round trips.
        rows += _simulate(load_world(scripts).world, rounds // 10, Path(folder))
    return rows


def _null_controller(world: World, rounds: int, folder: Path) -> list[Row]:
    """Return what a round trip of a controller takes that has next to nothing to decide, with and without a trace."""
    with ExitStack() as stack:
        plain, recorded = (
            stack.enter_context(stack.enter_context(served(world, _SETTINGS, wandering=0, trace=trace)).session())
            for trace in (None, folder / "trace.jsonl")
        )
        apart = stack.enter_context(stack.enter_context(served(world, _SETTINGS, wandering=0)).session())
        controller, observed = NullController(plain, world), NullController(recorded, world)
        together = NullController(apart, world, quantum=_QUANTUM)
        # Until all robots drive at different times.
        controller.go_on(2 * len(world.robots))
        observed.go_on(2 * len(world.robots))
        together.go_on(round(controller.now / _QUANTUM))
        began, before = controller.now, controller.round_trips
        alone = _alone(world)
        span = controller.now / controller.round_trips * _ROUND_TRIPS
        took = interleaved(
            [
                Variant("bare", lambda: [ask(plain, BARE, BARE_PAYLOAD) for _ in range(_ROUND_TRIPS)]),
                Variant("as large", partial(controller.pretend, _ROUND_TRIPS)),
                Variant("plain", partial(controller.go_on, _ROUND_TRIPS)),
                Variant("recorded", partial(observed.go_on, _ROUND_TRIPS)),
                Variant("together", partial(together.go_on, 1)),
                Variant("alone", lambda: alone.run(until=alone.now + span)),
            ],
            rounds,
        )
    simulated = (controller.now - began) / (controller.round_trips - before)
    # In a span there is as much to simulate as in the other variants' round trips on average.
    even = Rounds({**took.taken, "alone": [t * simulated * _ROUND_TRIPS / span for t in took.taken["alone"]]})
    robots = len(world.robots)
    return [
        _trip(even, f"{robots:,} robots: bare query", "bare", to="bare"),
        _trip(even, f"{robots:,} robots: round trip", "plain", to="bare", at_most=_DEAREST.get(robots)),
        _trip(even, f"{robots:,} robots: bare query with as much JSON", "as large", to="bare"),
        _trip(
            even, f"{robots:,} robots: round trip, against that", "plain", to="as large", at_most=_AS_LARGE.get(robots)
        ),
        _trip(even, f"{robots:,} robots: as much simulation without a wire", "alone", to="bare"),
        Row(
            f"{robots:,} robots: speed",
            took.spread("plain", lambda seconds: simulated * _ROUND_TRIPS / seconds),
            "simulated s/s",
        ),
        Row(
            f"{robots:,} robots: speed, results of {_QUANTUM:g} s together",
            took.spread("together", lambda seconds: _QUANTUM / seconds),
            "simulated s/s",
            at_least=_SPEEDS.get(robots),
        ),
        _trip(even, f"{robots:,} robots: round trip with a trace, against none", "recorded", to="plain", at_most=1.1),
    ]


def _trip(took: Rounds, what: str, name: str, *, to: str, at_most: float | None = None) -> Row:
    """Return the row of a round trip, of which each call made some."""
    each = took.spread(name, lambda seconds: seconds / _ROUND_TRIPS * 1e6)
    return Row(what, each, "µs", took.ratio(name, to=to), ratio_at_most=at_most)


def _alone(world: World) -> Simulator:
    """Return a simulator that does the same in this process, without a client."""
    crowd = Wanderers(world)
    simulator = Simulator(world, RunSettings(keep_results=10), [crowd])
    plan_everything(simulator)
    crowd.start(simulator, simulator.robots)
    collect_rarely()
    simulator.run(until=100.0)
    return simulator


def _hospital(missions: int, factor: float, bare: float) -> list[Row]:
    """Return what the hospital's mission takes, by bt-controller, in lockstep and at a real-time factor.

    Args:
        missions: How often it is run in lockstep.
        factor: Simulated seconds a wall second, in real time.
        bare: Wall seconds of a bare query: its round trips can't take less.
    """
    fast = [_mission.in_lockstep() for _ in range(missions)]
    slow = _mission.in_real_time(factor)
    speed = Spread.of(each.simulated / each.wall for each in fast)
    wall, trips = Spread.of(1e3 * each.wall for each in fast), fast[0].round_trips
    queries = 1e3 * trips * bare
    return [
        Row("hospital mission in lockstep", speed, "simulated s/s", at_least=4000.0),
        Row("hospital mission in lockstep: round trips", trips, "round trips"),
        Row("hospital mission in lockstep: as many bare queries", queries, "ms", 1.0),
        Row("hospital mission in lockstep: wall time", wall, "ms", wall / queries),
        Row(f"hospital mission in real time, factor {factor:g}", slow.simulated / slow.wall, "simulated s/s"),
    ]


def _simulate(world: World, rounds: int, folder: Path) -> list[Row]:
    """Return what ``hmrsim simulate`` takes for a world, without and with a trace."""
    path = folder / "trace.jsonl"
    plain, recorded = _Scripts(world, None), _Scripts(world, path)
    variants = [Variant(name, each.run, each.load) for name, each in (("plain", plain), ("recorded", recorded))]
    took = interleaved(variants, rounds)
    with_, without = (took.spread(name, lambda seconds: seconds * 1e3) for name in ("recorded", "plain"))
    ratio = took.ratio("recorded", to="plain")
    return [
        Row(f"simulate {world.name}", without, "ms", 1.0),
        Row(f"simulate {world.name} with a trace, against none", with_, "ms", ratio, ratio_at_most=1.06),
    ]


class _Scripts:
    """The scripts of a world in this process, run from their beginning each time."""

    def __init__(self, world: World, trace: Path | None) -> None:
        self._world = world
        self._path = trace
        self.load()

    def load(self) -> None:
        """Load the world again from its beginning."""
        settings = RunSettings(keep_results=1)
        self._trace = TraceFile(self._path, self._world, settings)
        self._simulator = Simulator(self._world, settings, self._trace.sinks)

    def run(self) -> None:
        """Run all scripts to their ends."""
        with self._trace.opened(self._simulator):
            self._simulator.run_scripts()
