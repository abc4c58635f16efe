"""The latency of results in real time: when a client receives a result, compared with when it is due.

Each robot shuttles on a separate lane, so that the duration of each drive is known. The due time counts from sending
the goal, so the latency includes the transport of the goal and of the result.
"""

from __future__ import annotations

import json
import math
import random
import statistics
import time
import uuid
from collections.abc import Sequence
from queue import SimpleQueue
from typing import Any

import zenoh

from benchmarks._report import Row
from benchmarks._wire import served
from hmrsim.settings.run import RunSettings
from hmrsim.world.model import World

QUICK: dict[str, Any] = {"window": 2.0}

_AT_MOST = 5.0
_TIMEOUT = 60.0
_SUCCEEDED = 4
_IGNORE: zenoh.handlers.Callback[zenoh.Reply] = zenoh.handlers.Callback(lambda _reply: None, indirect=False)


def run(*, factors: Sequence[float] = (1.0, 10.0), robots: int = 20, window: float = 30.0) -> list[Row]:
    """Return how late results are at each real-time factor, over *window* wall seconds with nothing else to do."""
    rows: list[Row] = []
    for factor in factors:
        chance = random.Random(1)
        lanes = {f"robot_{number}": factor * chance.uniform(0.5, 1.5) for number in range(robots)}
        with served(_world(lanes), RunSettings(real_time_factor=factor)) as world, world.session() as session:
            late = sorted(_Shuttles(session, lanes, factor).run(window))
        name = f"factor {factor:g}: a result is late by"
        rows += [
            Row(f"{name}, median of {len(late):,}", statistics.median(late) * 1e3, "ms", at_most=_AT_MOST),
            Row(f"{name}, 99th percentile", late[math.ceil(0.99 * len(late)) - 1] * 1e3, "ms"),
        ]
    return rows


def _world(lanes: dict[str, float]) -> World:
    """Return a world with a lane of so many meters for each robot, which drives 1 m/s."""
    ends = {
        f"{robot}_{end}": (end * meters, float(row))
        for row, (robot, meters) in enumerate(lanes.items())
        for end in (0, 1)
    }
    return World.model_validate(
        {
            "name": "shuttles",
            "waypoints": ends,
            "lanes": [(f"{robot}_0", f"{robot}_1") for robot in lanes],
            "robots": {robot: {"at": f"{robot}_0"} for robot in lanes},
        }
    )


class _Shuttles:
    """Sends robots to and fro, each from one end of its lane to the other.

    Args:
        session: An open session with the simulator.
        lanes: How long each robot's lane is, in simulated seconds.
        factor: Simulated seconds a wall second.
    """

    def __init__(self, session: zenoh.Session, lanes: dict[str, float], factor: float) -> None:
        self._session = session
        self._lanes = lanes
        self._factor = factor
        self._arrived: SimpleQueue[tuple[str, float, zenoh.Reply]] = SimpleQueue()
        self._ends = dict.fromkeys(lanes, 0)
        self._sent: dict[str, float] = {}

    def run(self, window: float) -> list[float]:
        """Return by how many wall seconds each result was late, of those that came within *window*."""
        late: list[float] = []
        for robot in self._lanes:
            self._send(robot)
        until = time.perf_counter() + window
        while time.perf_counter() < until:
            robot, arrived, reply = self._arrived.get()
            if reply.ok is None or json.loads(reply.ok.payload.to_bytes())["status"] != _SUCCEEDED:
                raise RuntimeError(f"{robot} has not arrived")
            late.append(arrived - self._sent[robot] - self._lanes[robot] / self._factor)
            self._send(robot)
        return late

    def _send(self, robot: str) -> None:
        """Send a robot to the other end, and ask for the result right behind."""
        self._ends[robot] = end = 1 - self._ends[robot]
        row, goal_id = float(list(self._lanes).index(robot)), uuid.uuid4().hex
        position = {"x": end * self._lanes[robot], "y": row}
        goal = json.dumps({"goal_id": goal_id, "goal": {"pose": {"pose": {"position": position}}}}).encode()

        def take(reply: zenoh.Reply) -> None:
            self._arrived.put((robot, time.perf_counter(), reply))

        key = f"hmrsim/{robot}/navigate_to_pose/_action"
        handler: zenoh.handlers.Callback[zenoh.Reply] = zenoh.handlers.Callback(take, indirect=False)
        self._sent[robot] = time.perf_counter()
        self._session.get(f"{key}/send_goal", _IGNORE, payload=goal, timeout=_TIMEOUT)
        wanted = json.dumps({"goal_id": goal_id}).encode()
        self._session.get(f"{key}/get_result", handler, payload=wanted, timeout=_TIMEOUT)
