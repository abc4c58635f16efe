"""The cost of monitoring properties: one formula on samples, compared with mstlo, and monitors on mission events."""

from __future__ import annotations

import importlib
import importlib.util
import math
import time
from collections.abc import Callable, Sequence
from functools import partial
from random import Random
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from benchmarks._report import Row
from benchmarks._spread import Spread
from bt_controller.loading.trees import load
from bt_controller.running.runner import run_tree
from hmrsim.program.memory import collect_rarely
from hmrsim.properties import Ended, Monitor, Properties, properties_of
from hmrsim.properties.temporal import Above, Always, Eventually, Implies, OnlineMonitor
from hmrsim.report.sink import ReportSink
from hmrsim.settings.run import RunSettings
from hmrsim.world_checks import load_world
from hmrsim_zenoh.client.client import Client
from hmrsim_zenoh.hosting.loopback_host import LoopbackHost

if TYPE_CHECKING:
    from hmrsim.history.occurrence import Occurrence
    from hmrsim.world.model import World

QUICK: dict[str, Any] = {"rounds": 2, "samples": 5_000, "missions": 3}

_TREE: Final = "bt_controller.examples.hospital:mission"
_FAST: Final = 200_000.0
"""Events a second."""
_CHEAP: Final = 1.0
"""Milliseconds for the hospital's mission."""
_SECOND: Final = 1_000_000_000
_OWN_PROPERTIES: Final = properties_of(
    {
        "properties": {
            "medicine_arrives": {"eventually": {"item": "medicine", "at": "ward_a", "carried": False}, "within": 600},
            "charged": {"always": {"battery": "*", "above": 0.05}},
            "keep_out": {"never": {"robot": "eve", "at": "lab"}},
            "retries": {
                "whenever": {"goal": "aborted", "robot": "*", "action": "navigate_to_pose"},
                "then": {"goal": "accepted", "robot": "$robot"},
                "within": 30,
            },
            "door_used": {"sometimes": {"event": "door_opened"}},
            "order_of_visits": {"ordered_visit": ["pharmacy", "ward_a"], "robot": "wall_e"},
        }
    }
)
"""Properties of places, batteries, goals and events, two of them of each of eight robots."""

_Samples = Sequence[tuple[int, tuple[float, float]]]


def run(*, rounds: int = 7, samples: int = 100_000, missions: int = 50) -> list[Row]:
    """Return how many samples and occurrences a second are taken, and what a mission costs.

    Args:
        rounds: How often each variant has its turn.
        samples: Of a formula in a turn.
        missions: That are watched in a turn.
    """
    collect_rarely()
    random = Random(1)
    world = load_world("hospital").world
    occurrences = _mission(world)
    return [
        _of_formula("G (a -> F[0,10] b), on and off", _flips(random, samples), rounds),
        _of_formula("G (a -> F[0,10] b), random numbers", _reals(random, samples), rounds),
        *_of_monitor("the seven built in", Properties(), _Watched(world, occurrences, missions), rounds),
        *_of_monitor("beside them six of a file", _OWN_PROPERTIES, _Watched(world, occurrences, missions), rounds),
        Row("occurrences of a mission", len(occurrences), ""),
    ]


def _of_formula(name: str, samples: _Samples, rounds: int) -> Row:
    """Return how many samples a second are taken, and how long that takes against mstlo, if it is installed."""
    ours, theirs = list[float](), list[float]()
    for _ in range(rounds):
        ours.append(_seconds(partial(_formula, samples)) / len(samples))
        if _installed():
            theirs.append(_seconds(partial(_mstlo, samples)) / len(samples))
    ratio = Spread.of(a / b for a, b in zip(ours, theirs, strict=True)) if theirs else None
    return Row(name, Spread.of(1.0 / each for each in ours), "samples/s", ratio, at_least=_FAST)


class _Watched(NamedTuple):
    """The events to monitor, and the number of missions per turn."""

    world: World
    occurrences: Sequence[Occurrence]
    missions: int


def _of_monitor(name: str, properties: Properties, watched: _Watched, rounds: int) -> list[Row]:
    """Return what a mission costs, and how many occurrences a second are taken."""
    each = [_seconds(partial(_watch, properties, watched)) / watched.missions for _ in range(rounds)]
    targets = properties == Properties()
    speed = Spread.of(len(watched.occurrences) / seconds for seconds in each)
    return [
        Row(f"a mission, {name}", Spread.of(1e3 * it for it in each), "ms", at_most=_CHEAP if targets else None),
        Row(f"its occurrences, {name}", speed, "occurrences/s", at_least=_FAST if targets else None),
    ]


def _seconds(work: Callable[[], object]) -> float:
    began = time.perf_counter()
    work()
    return time.perf_counter() - began


def _times(random: Random, count: int) -> list[int]:
    at, times = 0, []
    for _ in range(count):
        at += random.randint(1, 2 * _SECOND)
        times.append(at)
    return times


def _flips(random: Random, count: int) -> _Samples:
    """Return samples of two signals, one of which changes its sign each time, after a second on average."""
    values, samples = [-1.0, -1.0], []
    for at in _times(random, count):
        which = random.randrange(2)
        values[which] = -values[which]
        samples.append((at, (values[0], values[1])))
    return samples


def _reals(random: Random, count: int) -> _Samples:
    """Return samples of two signals that both change each time."""
    return [(at, (random.uniform(-1, 1), random.uniform(-1, 1))) for at in _times(random, count)]


def _formula(samples: _Samples) -> None:
    inner = Implies(Above("a"), Eventually(0, 10 * _SECOND, Above("b")))
    update = OnlineMonitor(Always(0, math.inf, inner), ("a", "b")).update
    for at, values in samples:
        update(at, values)


def _installed() -> bool:
    return importlib.util.find_spec("mstlo_python") is not None


def _mstlo(samples: _Samples) -> None:
    """Let mstlo monitor the same but for G, which it has with an end only; it takes one signal after the other."""
    mstlo = importlib.import_module("mstlo_python")
    make = mstlo.Formula
    formula = make.implies(make.gt("a", 0), make.eventually(0, 10, make.gt("b", 0)))
    monitor = mstlo.Monitor(formula, semantics="DelayedQuantitative", signal_interpolation="ZeroOrderHold")
    update = monitor.update
    for at, (a, b) in samples:
        seconds = at / _SECOND
        update("a", a, seconds)
        update("b", b, seconds)


def _mission(world: World) -> list[Occurrence]:
    """Return all that happens in the hospital's mission, motions and batteries included."""
    found: list[Occurrence] = []
    with (
        LoopbackHost(
            world, RunSettings(), watchers=lambda simulator, _pacing: [ReportSink(simulator, found.append)]
        ) as host,
        Client(session=host.open_session(), name="bt_controller") as client,
    ):
        run_tree(client, load(_TREE), [*host.simulator.robots])
        return [*found]


def _watch(properties: Properties, watched: _Watched) -> None:
    for _ in range(watched.missions):
        monitor = Monitor(properties, watched.world)
        take = monitor.take
        for occurrence in watched.occurrences:
            take(occurrence)
        monitor.end(None, Ended("succeeded"))
        monitor.verdicts()
