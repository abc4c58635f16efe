"""Behavior trees of many robots in one process, in lockstep: what an event costs it, however many robots there are.

An event takes one round trip, so that the processor time of a bare query in the same process is what it is compared
with.
"""

from __future__ import annotations

import gc
import random
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from py_trees.behaviours import TickCounter
from py_trees.common import Status
from py_trees.composites import Sequence as Steps
from py_trees.decorators import Repeat

from benchmarks._fleet import SIDE, grid_world
from benchmarks._processes import child
from benchmarks._report import Row
from benchmarks._spread import Spread
from benchmarks._timing import Rounds, microseconds
from benchmarks._wire import BARE, BARE_PAYLOAD, ask, served
from bt_controller.behaviours.robot_actions import pose_goal
from bt_controller.core.action_leaf import ActionLeaf
from bt_controller.loading.trees import Plan
from bt_controller.running.clocks import STOP, Mailbox, clock_for
from bt_controller.running.mission import missions_for, prepare
from bt_controller.running.runner import Runner
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.nav2_msgs import Wait
from hmrsim.settings.run import RunSettings
from hmrsim_zenoh.client.client import Client
from hmrsim_zenoh.wire.options import SessionOptions

if TYPE_CHECKING:
    from multiprocessing.connection import Connection

    from py_trees.behaviour import Behaviour

    from bt_controller.running.clocks import Clock
    from hmrsim.world.model import World
    from hmrsim_zenoh.client.goal_handle import GoalHandle

QUICK: dict[str, Any] = {"sizes": (1, 10, 100), "results": 120, "polled": 20, "runs": 1}

_SETTINGS = RunSettings(clock="lockstep", keep_results=10, participant_timeout=300.0)
_STOPS = 6
_NODES = 2 + 3 * _STOPS
_GROWTH = 1.5
"""What the machine does meanwhile may make an event so much dearer; a look at each robot would by far more."""
_EVENT = 250.0
"""Microseconds of processor time."""
_SET_UP = 5.0
_QUERIES = 300
"""Bare queries, after as many that warm up."""


def run(
    *,
    sizes: Sequence[int] = (1, 10, 100, 1000),
    results: int = 1200,
    polled: int = 200,
    runs: int = 3,
    side: int = SIDE,
) -> list[Row]:
    """Return what trees cost their process, those that are ticked when something happened and those that are polled.

    Args:
        sizes: Numbers of robots.
        results: How many goals end at least; each tree is run to its end.
        polled: After how many results the polled trees are stopped.
        runs: How often trees are run; the sizes take turns.
        side: Waypoints along each side of the grid.
    """
    worlds = {robots: grid_world(robots, side=side) for robots in sizes}
    costs: dict[int, list[_Cost]] = {robots: [] for robots in sizes}
    for _ in range(runs):
        for robots, world in worlds.items():
            costs[robots].append(_measured(world, -(-results // (2 * _STOPS * robots)), None, None))
    alone = Spread.of(1e6 * _py_trees_alone(results) for _ in range(max(runs, 1)))
    rows = [Row("py_trees alone: a tick of such a tree", alone, "µs")]
    for robots, world in worlds.items():
        found = costs[robots]
        taken = {"event": [each.event for each in found], "query": [each.query for each in found]}
        took = Rounds({**taken, "one": [each.event for each in costs[sizes[0]]]})
        each = _measured(world, 1, 1.0, min(polled, 2 * _STOPS * robots)).event
        name = f"{robots:,} robot{'s' * (robots > 1)}"
        event = took.spread("event", microseconds)
        rows += [
            Row(f"{name}: set-up", Spread.of(cost.set_up for cost in found), "s", at_most=_SET_UP),
            Row(f"{name}: an event", event, "µs", took.ratio("event", to="one"), _EVENT, ratio_at_most=_GROWTH),
            Row(f"{name}: a bare query", took.spread("query", microseconds), "µs", took.ratio("query", to="one")),
            Row(f"{name}: events", found[0].results, "results"),
            Row(f"{name}: an event, all polled each second", 1e6 * each, "µs", 1e6 * each / event),
        ]
    return rows


def _py_trees_alone(ticks: int) -> float:
    """Return the processor seconds of a tick of a tree of 20 nodes whose leaves send nothing, and take two ticks."""
    stops = []
    for number in range(_STOPS):
        go, rest = (TickCounter(f"{name} {number}", 1, Status.SUCCESS) for name in ("Go", "Rest"))
        stops.append(Steps(f"Stop {number}", memory=True, children=[go, rest]))
    tree = Repeat("Rounds", Steps("Round", memory=True, children=stops), -1)
    began = time.process_time()
    for _ in range(ticks):
        tree.tick_once()
    return (time.process_time() - began) / ticks


@dataclass(frozen=True)
class _Cost:
    """Processor seconds of the controller's process, in all its threads.

    Attributes:
        set_up: For building and setting up all trees, and for sending their first goals.
        event: From one result to the next.
        query: For a bare query.
        results: How many goals ended.
    """

    set_up: float
    event: float
    query: float
    results: int


def _measured(world: World, rounds: int, period: float | None, most: int | None) -> _Cost:
    """Return what it costs to run each robot's tree so many times, or until so many goals have ended."""
    with ExitStack() as stack:
        simulator = stack.enter_context(served(world, _SETTINGS, wandering=0))
        controller = stack.enter_context(child(_control, simulator.endpoint, world, rounds, period, most))
        cost: _Cost = controller.receive()
    return cost


def _control(
    pipe: Connection, endpoint: str, world: World, rounds: int, period: float | None, most: int | None
) -> None:
    mailbox, ends = Mailbox(), _Ends()
    with Client(SessionOptions(connect=(endpoint,)), clock="lockstep", name="controller") as client:
        client.wait_for_simulator(10.0)
        began = time.process_time()
        plan = Plan("tree", lambda robot: _tree(robot, world, rounds, ends.note), takes_robot=True, confirmed=False)
        missions = missions_for(list(world.robots), plan)
        prepare(missions)
        gc.freeze()  # as the command does
        clock = _Watched(clock_for(client, mailbox, feedback=period is not None, grace=3.0), ends, most)
        outcome = Runner(client, missions, clock, mailbox, show=None, period=period).run()
        if most is None and not outcome.succeeded:
            raise RuntimeError(f"trees failed: {outcome.statuses}")
        query = _bare_query(client)
    pipe.send(_Cost(clock.began - began, (clock.ended - clock.began) / ends.number, query, ends.number))


def _bare_query(client: Client) -> float:
    """Return the processor seconds that a query takes that says nothing."""
    for _ in range(_QUERIES):
        ask(client.session, BARE, BARE_PAYLOAD)
    began = time.process_time()
    for _ in range(_QUERIES):
        ask(client.session, BARE, BARE_PAYLOAD)
    return (time.process_time() - began) / _QUERIES


class _Ends:
    """Counts the goals that ended."""

    def __init__(self) -> None:
        self.number = 0

    def note(self) -> None:
        self.number += 1


class _Watched:
    """A clock that takes the processor's time when trees begin and when they don't go on, and may stop them."""

    def __init__(self, clock: Clock, ends: _Ends, most: int | None) -> None:
        self._clock = clock
        self._ends = ends
        self._most = most
        self.began = 0.0
        self.ended = 0.0

    @property
    def now(self) -> float | None:
        return self._clock.now

    @property
    def elapsed(self) -> float | None:
        return self._clock.elapsed

    def wait(self, until: float | None) -> frozenset[str]:
        self.began = self.began or time.process_time()
        if self._most is not None and self._ends.number >= self._most:
            return frozenset({STOP})
        return self._clock.wait(until)

    def settle(self, done: Callable[[], bool], seconds: float) -> None:
        self.ended = time.process_time()
        self._clock.settle(done, seconds)

    def close(self) -> None:
        self._clock.close()


class _Leaf(ActionLeaf[Any, Any, Any]):
    """A leaf whose goals are counted when they have ended."""

    note: Callable[[], None]

    def ended(self, handle: GoalHandle[Any, Any]) -> Any:
        self.note()
        return super().ended(handle)


def _tree(robot: str, world: World, rounds: int, note: Callable[[], None]) -> Behaviour:
    """Return a tree of 20 nodes: six times to a random waypoint, with a rest at each, and all of it some times."""
    chance = random.Random(robot)
    points = list(world.points.values())
    stops = []
    for number in range(_STOPS):
        go: _Leaf = _Leaf(f"Go {number}", "navigate_to_pose", pose_goal(*chance.choice(points)))
        rest: _Leaf = _Leaf(f"Rest {number}", "wait", Wait.Goal(time=Duration.from_seconds(chance.uniform(1.0, 9.0))))
        go.note = rest.note = note
        stops.append(Steps(f"Stop {number}", memory=True, children=[go, rest]))
    return Repeat("Rounds", Steps("Round", memory=True, children=stops), rounds)
