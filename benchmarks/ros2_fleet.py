"""ROS 2 at fleet size: how soon a ROS node sees all robots and gets its first result, and what idling costs."""

from __future__ import annotations

import tempfile
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import zenoh

from benchmarks._fleet import SIDE, grid_world
from benchmarks._processes import (
    HMRSIM,
    PATIENCE,
    command,
    free_port,
    line_of,
    memory,
    processor_seconds,
    settle,
    threads,
)
from benchmarks._report import Row
from benchmarks._ros2_wire import Graph, RosGoalSender, open_session
from hmrsim.interfaces.geometry_msgs import Point, Pose, PoseStamped
from hmrsim.interfaces.nav2_msgs import NavigateToPose
from hmrsim_zenoh.ros2 import keys
from hmrsim_zenoh.ros2.keys import Kind

if TYPE_CHECKING:
    from hmrsim.world.model import World

QUICK: dict[str, Any] = {"fleets": (1, 10), "idle": 0.5, "commanded": 10}

_QUIET = 1.0
"""Seconds without a new token after which there are no more."""
_NODE = "bt_navigator"
_MAX_THREADS = 39
_LIMITS = {"seen": 3.0, "first": 1.0, "idle": 5.0}
_COMMANDED_SECONDS, _COMMANDED_MB = 10.0, 1000.0
_SPEED = 5


def run(
    *, fleets: tuple[int, ...] = (1, 100, 300, 1000), idle: float = 5.0, side: int = SIDE, commanded: int = 1000
) -> list[Row]:
    """Return the figures of fleets of several sizes, and of one that is commanded."""
    return [*(row for robots in fleets for row in _fleet(robots, idle, side)), *_commanded(commanded, side)]


def _fleet(robots: int, idle: float, side: int) -> list[Row]:
    limit = _LIMITS if robots <= 300 else {}  # noqa: PLR2004 - what is promised
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "fleet.yaml"
        file.write_text(grid_world(robots, side=side).model_dump_json(exclude_defaults=True))
        endpoint = f"tcp/127.0.0.1:{free_port()}"
        with command(*HMRSIM, "run", str(file), "--ros2", "--listen", endpoint, "--log-level", "error") as simulator:
            line_of(simulator)
            ready = time.perf_counter()
            with open_session(endpoint) as session:
                graph = _Observer(session)
                first = graph.result_of(session, "wait") - ready
                seen = graph.when_all(robots) - ready
                tokens = graph.settled()
            began = time.perf_counter()
            with open_session(endpoint) as late:
                list(late.liveliness().get(keys.all_tokens(0), timeout=PATIENCE))
                later = _Observer(late).result_of(late, "spin") - began
            used = processor_seconds(simulator.pid)
            time.sleep(idle)
            used = (processor_seconds(simulator.pid) - used) / idle * 100
            count = threads(simulator.pid)
    fleet = f"{robots:,} robot{'s' * (robots > 1)}"
    return [
        Row(f"{fleet}: tokens that nothing asked for", tokens, "tokens"),
        Row(f"{fleet}: {_NODE} of all is seen after the start in", seen, "s", at_most=limit.get("seen")),
        Row(f"{fleet}: first result after the start in", first, "s", at_most=limit.get("first")),
        Row(f"{fleet}: a node that comes later has its first result in", later, "s", at_most=limit.get("first")),
        Row(f"{fleet}: processor time while idle", used, "% of a core", at_most=limit.get("idle")),
        Row(f"{fleet}: threads of the simulator", count, "threads", at_most=_MAX_THREADS),
    ]


def _commanded(robots: int, side: int) -> list[Row]:
    """Return what it takes to send each robot to the next waypoint, by an action client each of one process."""
    world = grid_world(robots, side=side)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "fleet.yaml"
        file.write_text(world.model_dump_json(exclude_defaults=True))
        endpoint = f"tcp/127.0.0.1:{free_port()}"
        options = ("--ros2", "--listen", endpoint, "--log-level", "error", "--real-time-factor", str(_SPEED))
        with command(*HMRSIM, "run", str(file), *options) as simulator:
            line_of(simulator)
            settle(simulator.pid)
            used, own, began = processor_seconds(simulator.pid), time.process_time(), time.perf_counter()
            # Closing a session with thousands of declarations may take longer than Zenoh allows.
            with suppress(zenoh.ZError), open_session(endpoint) as session:
                _send_on(session, world)
                took, own = time.perf_counter() - began, time.process_time() - own
                used, (size, _) = processor_seconds(simulator.pid) - used, memory(simulator.pid)
    name = f"{robots:,} action clients of one process, each with a goal"
    return [
        Row(f"{name}: all have results in", took, "s", at_most=_COMMANDED_SECONDS),
        Row(f"{name}: processor time of the clients", own, "s"),
        Row(f"{name}: processor time of the simulator", used, "s"),
        Row(f"{name}: memory of the simulator", size, "MB", at_most=_COMMANDED_MB),
    ]


def _send_on(session: zenoh.Session, world: World) -> None:
    """Send each robot to a waypoint next to it, and return when all have arrived."""
    arrived = threading.Semaphore(0)
    graph = Graph(session)
    beside = {lane.from_: lane.to for lane in world.lanes} | {lane.to: lane.from_ for lane in world.lanes}
    senders = []
    for number, (robot, spec) in enumerate(world.robots.items()):
        x, y = world.point(beside[str(spec.at)])
        goal = NavigateToPose.Goal(pose=PoseStamped(pose=Pose(position=Point(x=x, y=y))))
        sender = RosGoalSender(session, robot, "navigate_to_pose", 5 * number + 1, goal)
        sender.subscribe()
        senders.append(sender)
    graph.when([f"/{robot}/navigate_to_pose" for robot in world.robots])
    for sender in senders:
        sender.right_behind(lambda reply: arrived.release() if reply.ok else None)
    for _ in senders:
        if not arrived.acquire(timeout=PATIENCE):
            raise RuntimeError("a goal has no result")


class _Observer:
    """The tokens that a ROS node sees."""

    def __init__(self, session: zenoh.Session) -> None:
        self._changed = threading.Condition()
        self._seen: set[tuple[Kind, str]] = set()
        self._nodes = 0
        self._count, self._last = 0, time.perf_counter()
        handler: zenoh.handlers.Callback[zenoh.Sample] = zenoh.handlers.Callback(self._take, indirect=False)
        self._subscriber = session.liveliness().declare_subscriber(keys.all_tokens(0), handler, history=True)

    def _take(self, sample: zenoh.Sample) -> None:
        token = keys.read_token(str(sample.key_expr))
        if token is None or (token.endpoint and token.endpoint.kind in {Kind.CLIENT, Kind.SUBSCRIBER}):
            return
        with self._changed:
            self._count, self._last = self._count + 1, time.perf_counter()
            if token.endpoint is None and token.node.name == _NODE:
                self._nodes += 1
                self._changed.notify_all()
            if token.endpoint is not None and (what := (token.endpoint.kind, token.endpoint.name)) not in self._seen:
                self._seen.add(what)
                self._changed.notify_all()

    def result_of(self, session: zenoh.Session, action: str) -> float:
        """Send a goal of no length to a robot, once its server is seen, and return when its result was there."""
        goals = RosGoalSender(session, "robot_0", action)
        roles = {"send_goal": Kind.SERVICE, "get_result": Kind.SERVICE, "status": Kind.PUBLISHER}
        wanted = {(kind, f"/robot_0/{action}/_action/{role}") for role, kind in roles.items()}
        self._wait(lambda: wanted <= self._seen)
        goals.one_by_one()
        return time.perf_counter()

    def when_all(self, robots: int) -> float:
        """Wait until a node of each robot is seen, and return the time."""
        self._wait(lambda: self._nodes >= robots)
        return self._last

    def _wait(self, until: Callable[[], bool]) -> None:
        with self._changed:
            if not self._changed.wait_for(until, PATIENCE):
                raise RuntimeError(f"only {self._count} tokens are there")

    def settled(self) -> int:
        """Wait until no further tokens arrive, and return their number."""
        while time.perf_counter() - self._last < _QUIET:
            time.sleep(_QUIET / 10)
        return self._count
