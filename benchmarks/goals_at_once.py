"""A goal for each robot of a fleet at once, by either wire: until the last result has come.

The client subscribes to feedback and status of every robot first, as an action client of ROS does.
"""

from __future__ import annotations

import json
import time
import uuid
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from queue import SimpleQueue
from typing import Any, Final

import zenoh

from benchmarks._fleet import SIDE, grid_world
from benchmarks._processes import PATIENCE, processor_seconds, settle
from benchmarks._report import Row
from benchmarks._ros2_wire import HEADER, Graph, RosGoalSender, open_session
from benchmarks._spread import Spread
from benchmarks._wire import Served, served
from hmrsim.settings.run import RunSettings
from hmrsim_zenoh.ros2.wires import RmwZenoh

QUICK: dict[str, Any] = {"robots": 20, "rounds": 10}

_SUCCEEDED = 4
_NEAR_JSON, _LIKE_JSON = 1.5, 1.0
_ENTITIES = 5
"""Tokens of an action client."""
_IGNORE: Final[zenoh.handlers.Callback[Any]] = zenoh.handlers.Callback(lambda _: None, indirect=False)

Take = Callable[[zenoh.Reply], None]
Send = Callable[[Take], None]
"""Sends a goal and asks for its result."""


def run(*, robots: int = 500, rounds: int = 5, side: int = SIDE) -> list[Row]:
    """Return the seconds by JSON, and by ROS 2's wire against them; of the wall, and of the simulator's processor."""
    world = grid_world(robots, side=side)
    took: dict[str, Spread] = {}
    used: dict[str, float] = {}
    for name, senders, status in (("JSON", _json, _json_status), ("ROS 2", _ros, _ros_status)):
        with (
            served(world, RunSettings(keep_results=10), wires=(RmwZenoh(),)) as server,
            senders(server, list(world.robots)) as sends,
        ):
            _round(sends, status)
            # A large fleet is still declaring its servers.
            settle(server.child.pid)
            before = processor_seconds(server.child.pid)
            took[name] = Spread.of(_round(sends, status) for _ in range(rounds))
            used[name] = (processor_seconds(server.child.pid) - before) / rounds
    return [
        Row(f"{robots:,} goals at once, {name}{of}", seconds, "s", seconds / times["JSON"], ratio_at_most=limit)
        for times, of, target in ((took, "", _NEAR_JSON), (used, ": the simulator's processor", _LIKE_JSON))
        for (name, seconds), limit in zip(times.items(), (None, target), strict=True)
    ]


def _round(sends: list[Send], status: Callable[[bytes], int]) -> float:
    """Send a goal to each robot; return the seconds until all have succeeded."""
    replies: SimpleQueue[zenoh.Reply] = SimpleQueue()
    began = time.perf_counter()
    for send in sends:
        send(replies.put)
    for _ in sends:
        reply = replies.get(timeout=PATIENCE)
        if reply.ok is None or status(reply.ok.payload.to_bytes()) != _SUCCEEDED:
            raise RuntimeError("a goal has not succeeded")
    return time.perf_counter() - began


@contextmanager
def _json(server: Served, robots: list[str]) -> Iterator[list[Send]]:
    with server.session() as session:
        subscriptions = [
            session.declare_subscriber(f"hmrsim/{robot}/wait/_action/{topic}", _IGNORE)
            for robot in robots
            for topic in ("feedback", "status")
        ]
        session.get("hmrsim/_world/info").recv()
        yield [partial(_send, session, f"hmrsim/{robot}/wait/_action") for robot in robots]
        subscriptions.clear()


def _send(session: zenoh.Session, key: str, take: Take) -> None:
    goal_id = uuid.uuid4().hex
    session.get(f"{key}/send_goal", _IGNORE, payload=json.dumps({"goal_id": goal_id, "goal": {}}), timeout=PATIENCE)
    handler: zenoh.handlers.Callback[zenoh.Reply] = zenoh.handlers.Callback(take, indirect=False)
    session.get(f"{key}/get_result", handler, payload=json.dumps({"goal_id": goal_id}), timeout=PATIENCE)


def _json_status(payload: bytes) -> int:
    return int(json.loads(payload)["status"])


@contextmanager
def _ros(server: Served, robots: list[str]) -> Iterator[list[Send]]:
    with open_session(server.endpoint) as session:
        graph = Graph(session)
        senders = [RosGoalSender(session, robot, "wait", _ENTITIES * at) for at, robot in enumerate(robots)]
        for sender in senders:
            sender.subscribe()
        # In a large fleet servers are declared when a client looks for them.
        graph.when([f"/{robot}/wait" for robot in robots])
        yield [sender.right_behind for sender in senders]


def _ros_status(payload: bytes) -> int:
    return payload[len(HEADER)]
