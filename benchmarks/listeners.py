"""The cost of subscribers: a process that follows the feedback of every robot, and feedback without a subscriber."""

from __future__ import annotations

import contextlib
import itertools
import json
import threading
import time
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from benchmarks._fleet import LANE_SECONDS, SIDE, Wanderers, grid_world, plan_everything
from benchmarks._processes import Child, child, processor_seconds
from benchmarks._report import Row
from benchmarks._timing import Variant, interleaved
from benchmarks._wire import Served, served
from hmrsim.program.memory import collect_rarely
from hmrsim.settings.run import RunSettings
from hmrsim.simulation.simulator import Simulator
from hmrsim_zenoh.wire.options import SessionOptions
from hmrsim_zenoh.wire.session import open_client

if TYPE_CHECKING:
    from multiprocessing.connection import Connection

    import zenoh

    from hmrsim.world.model import World

QUICK: dict[str, Any] = {"sizes": (100, 1000), "window": 1.0, "robots": 100, "rounds": 3}

_FEEDBACK = "hmrsim/*/navigate_to_pose/_action/feedback"
_TARGETS = {(10_000, 1.0): 25.0}
_EVENTS_A_ROUND = 10_000
_SETTLING = 1.0
"""Wall seconds between the first message and the measurement."""


def run(
    *,
    sizes: Sequence[int] = (100, 1000, 10_000),
    rates: Sequence[float] = (1.0, 10.0),
    window: float = 10.0,
    robots: int = 1000,
    rounds: int = 15,
    side: int = SIDE,
) -> list[Row]:
    """Return processor shares at real-time factor 1, and what unheard feedback costs without a pace."""
    rows: list[Row] = []
    for size in sizes:
        for rate in rates:
            rows += _heard(size, rate, window, side)
    return [*rows, _unheard(grid_world(robots, side=side), rounds)]


def _heard(robots: int, rate: float, window: float, side: int) -> list[Row]:
    """Return rows of one number of robots, whose feedback is sampled *rate* times a second."""
    settings = RunSettings(feedback_rate=rate, keep_results=10)
    with served(grid_world(robots, side=side), settings, wandering=robots) as world:
        alone, _, _ = _shares(world, None, window / 2)
        with child(_listen, world.endpoint) as listener:
            listener.receive()
            time.sleep(_SETTLING)
            simulator, listening, messages = _shares(world, listener, window)
    name = f"{robots:,} robots at {rate:g} Hz"
    return [
        Row(f"{name}: simulator, no subscriber", alone, "% of a core"),
        Row(f"{name}: simulator", simulator, "% of a core", at_most=_TARGETS.get((robots, rate))),
        Row(f"{name}: listener", listening, "% of a core"),
        Row(f"{name}: received, of those expected", 100 * messages / (robots * rate), "%"),
    ]


def _shares(world: Served, listener: Child | None, window: float) -> tuple[float, float, float]:
    """Return how much of a core the simulator and the listener use, in percent, and the messages a second."""
    pids = [world.child.pid] + ([listener.pid] if listener else [])
    counted = listener.ask("count") if listener else 0
    used, began = [processor_seconds(pid) for pid in pids], time.perf_counter()
    time.sleep(window)
    took = time.perf_counter() - began
    shares = [100 * (processor_seconds(pid) - before) / took for pid, before in zip(pids, used, strict=True)]
    messages = (listener.ask("count") - counted) / took if listener else 0.0
    return shares[0], shares[-1], messages


def _listen(pipe: Connection, endpoint: str) -> None:
    """Read all feedback, and tell how many messages there were whenever asked; first when there was one."""
    heard = itertools.count()
    first = threading.Event()

    def take(sample: zenoh.Sample) -> None:
        json.loads(sample.payload.to_bytes())
        next(heard)
        first.set()

    with open_client(SessionOptions(connect=(endpoint,))) as session:
        session.declare_subscriber(_FEEDBACK, take)
        first.wait()
        pipe.send("listening")
        with contextlib.suppress(EOFError):
            for asked in itertools.count(1):
                pipe.recv()
                pipe.send(next(heard) - asked)


def _unheard(world: World, rounds: int) -> Row:
    """Return the cost of feedback without a subscriber, against a simulator that can't give any.

    Both do the same: equal seeds, and equal spans of simulated time, turn about.
    """
    crowds = Wanderers(world), Wanderers(world)
    giving, silent = (Simulator(world, RunSettings(keep_results=10), [crowd]) for crowd in crowds)
    silent.dispatcher.feedback.sample = lambda *_: None  # type: ignore[method-assign]
    for simulator, crowd in zip((giving, silent), crowds, strict=True):
        plan_everything(simulator)
        crowd.start(simulator, simulator.robots)
    collect_rarely()
    span = _EVENTS_A_ROUND * LANE_SECONDS / len(world.robots)
    variants = [Variant("silent", partial(_go_on, silent, span)), Variant("giving", partial(_go_on, giving, span))]
    took = interleaved(variants, rounds)
    return Row(
        f"{len(world.robots):,} robots, feedback without a subscriber, against none",
        took.spread("giving", lambda seconds: span / seconds),
        "simulated s/s",
        took.ratio("giving", to="silent"),
        ratio_at_most=1.03,
    )


def _go_on(simulator: Simulator, seconds: float) -> None:
    simulator.run(until=simulator.now + seconds)
