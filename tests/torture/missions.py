"""Random missions, over Zenoh and within one process: what clients see and the trace are the same, byte for byte.

::

    python -m tests.torture.missions --count 1000 --seed 1
"""

from __future__ import annotations

import argparse
import json
import random
import sys
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from hmrsim.actions import registry
from hmrsim.errors import HmrsimError
from hmrsim.settings.run import RunSettings
from hmrsim.trace.writer import Header, Trace
from hmrsim.world_checks import load_world
from hmrsim_zenoh import Client, SessionOptions
from hmrsim_zenoh.hosting.host import Host
from hmrsim_zenoh.hosting.loopback_host import LoopbackHost
from tests.patience import PATIENCE

if TYPE_CHECKING:
    from hmrsim.world_checks import LoadedWorld
    from hmrsim_zenoh import GoalHandle

WORLDS: Final = ("hospital", "scenario1", "scenario2", "hospital_fleet", "zoo/door", "zoo/lift", "zoo/charger_queue")

_SETTINGS: Final = RunSettings(clock="lockstep", feedback_rate=2.0)
_ANY_PORT: Final = SessionOptions(listen=("tcp/127.0.0.1:0",))


class Seen(NamedTuple):
    """A mission as its client saw it, and its trace."""

    log: list[Any]
    trace: str


def over_zenoh(loaded: LoadedWorld, seed: int) -> Seen:
    """Return the mission over Zenoh, with a thread for the simulation."""
    pieces: list[str] = []
    trace = Trace(Header.of(loaded.world, _SETTINGS), pieces.append)
    with Host(loaded, _ANY_PORT, _SETTINGS, sinks=[trace]) as host:
        host.start()
        with Client(SessionOptions(connect=(host.endpoints[0],))) as client:
            log = mission(client, loaded, random.Random(seed))
    trace.close(host.simulator.now)
    return Seen(log, "".join(pieces))


def within(loaded: LoadedWorld, seed: int) -> Seen:
    """Return the mission in this process."""
    pieces: list[str] = []
    trace = Trace(Header.of(loaded.world, _SETTINGS), pieces.append)
    with LoopbackHost(loaded.world, _SETTINGS, sinks=[trace]) as host, Client(session=host.open_session()) as client:
        log = mission(client, loaded, random.Random(seed))
    trace.close(host.simulator.now)
    return Seen(log, "".join(pieces))


def mission(client: Client, loaded: LoadedWorld, chance: random.Random) -> list[Any]:
    """Run random commands of robots; return the client's view."""
    steps = _Steps(client, loaded, chance)
    for _ in range(chance.randint(3, 25)):
        steps.next()
    steps.end()
    return steps.log


class _Steps:
    """The steps of one mission."""

    def __init__(self, client: Client, loaded: LoadedWorld, chance: random.Random) -> None:
        self._client = client
        self._chance = chance
        self._world = loaded.world
        self._robots = {robot["name"]: robot["actions"] for robot in client.info()["robots"]}
        self._goals: list[GoalHandle[Any, Any]] = []
        self._kinds: dict[Callable[[], object], int] = {
            self._send: 8,
            self._await: 4,
            self._sleep: 3,
            self._cancel: 2,
            self._read: 2,
            self._break: 1,
            self._listen: 1,
            self._reset: 1,
        }
        self.log: list[Any] = []

    def next(self) -> None:
        """Make one step, and record its outcome."""
        (kind,) = self._chance.choices([*self._kinds], [*self._kinds.values()])
        try:
            self.log.append((kind.__name__, kind(), self._client.now))
        except HmrsimError as error:
            self.log.append((kind.__name__, type(error).__name__, str(error)))

    def end(self) -> None:
        """Cancel open goals, and record how all goals ended."""
        for goal in self._goals:
            goal.cancel()
        self.log.append([self._ended(goal) for goal in self._goals])

    def _ended(self, goal: GoalHandle[Any, Any]) -> object:
        try:
            return goal.result(PATIENCE).model_dump(mode="json"), goal.status.name
        except HmrsimError as error:
            return type(error).__name__, str(error), goal.status.name

    def _send(self) -> object:
        robot = self._chance.choice([*self._robots])
        name = self._chance.choice(self._robots[robot])
        action = registry()[name]
        feedback = self._note_feedback if self._chance.random() < 0.3 else None
        try:
            message = action.goal.model_validate(self._message(name))
        except ValueError:
            return name
        goal = self._client.action_client(robot, action).send_goal(message, on_feedback=feedback)
        self._goals.append(goal)
        return robot, name, goal.goal_id

    def _message(self, action: str) -> dict[str, Any]:
        pose = {"pose": {"position": dict(zip("xy", self._point(), strict=True))}}
        thing = self._chance.choice([*self._world.items, "nothing"])
        dock = self._chance.choice([*self._world.docks, "nowhere"])
        some = [pose, {"pose": {"position": dict(zip("xy", self._point(), strict=True))}}]
        known: dict[str, dict[str, Any]] = {
            "navigate_to_pose": {"pose": pose},
            "navigate_through_poses": {"poses": some},
            "follow_waypoints": {"poses": some},
            "compute_path_to_pose": {"goal": pose},
            "wait": {"time": {"sec": self._chance.randint(0, 20)}},
            "pickup": {"target_name": thing},
            "place": {"attached_object_name": thing},
            "dock_robot": {"dock_id": dock},
            "spin": {"target_yaw": self._chance.uniform(-3.0, 3.0)},
        }
        return known.get(action, {})

    def _point(self) -> tuple[float, float]:
        x, y = self._chance.choice([*self._world.points.values()])
        off = self._chance.choice([0.0, 0.0, 0.0, 0.3])
        return x + off, y - off

    def _note_feedback(self, feedback: Any) -> None:
        self.log.append(("feedback", type(feedback).__qualname__))

    def _await(self) -> object:
        if not self._goals:
            return None
        return self._ended(self._chance.choice(self._goals[-3:]))

    def _sleep(self) -> object:
        self._client.sleep(self._chance.choice([0.0, 0.5, 3.0, 20.0]))
        return None

    def _cancel(self) -> object:
        if not self._goals:
            return None
        goal = self._chance.choice(self._goals)
        goal.cancel()
        return goal.goal_id

    def _read(self) -> object:
        robot = self._chance.choice([*self._robots])
        key = self._chance.choice([f"{robot}/odom", f"{robot}/battery_state", "_world/clock", "_world/scene"])
        return self._client.get(f"hmrsim/{key}", PATIENCE).decode()

    def _break(self) -> object:
        robot = self._chance.choice([*self._robots])
        fault = self._chance.choice(
            [
                {"type": "breakdown", "duration": 10.0},
                {"type": "slip", "factor": 0.5, "duration": 10.0},
                {"type": "messages_lost", "duration": 5.0},
                {"type": "localisation_jump", "dx": 0.5},
            ]
        )
        request = json.dumps({**fault, "robot": robot})
        return self._client.get("hmrsim/_world/inject_fault", PATIENCE, payload=request.encode()).decode()

    def _listen(self) -> object:
        key = self._chance.choice(["hmrsim/_world/events", "hmrsim/*/odom", "hmrsim/**"])
        self._client.subscribe(key, lambda _key, _payload: None)
        return key

    def _reset(self) -> object:
        if self._chance.random() < 0.7:
            return None
        return self._client.get("hmrsim/_world/reset_simulation", PATIENCE, payload=b"{}").decode()


def compare(world: str, seed: int) -> str:
    """Return how a mission differs within one process, or nothing."""
    loaded = load_world(world)
    there, here = over_zenoh(loaded, seed), within(loaded, seed)
    for name, one, other in (
        ("trace", there.trace.splitlines(), here.trace.splitlines()),
        ("log", there.log, here.log),
    ):
        for number, (a, b) in enumerate(zip(one, other, strict=False)):
            if a != b:
                return f"{world} {seed}: {name} {number}:\n  {a!r:.400}\n  {b!r:.400}"
        if len(one) != len(other):
            return f"{world} {seed}: {name}: {len(one)} or {len(other)} entries"
    return ""


def main() -> int:
    """Compare many missions; print those that differ."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    began, differ = time.monotonic(), 0
    for number in range(arguments.count):
        seed = arguments.seed * 1_000_000 + number
        if text := compare(WORLDS[number % len(WORLDS)], seed):
            differ += 1
            print(text, flush=True)  # noqa: T201
    seconds = time.monotonic() - began
    print(f"{arguments.count} missions in {seconds:.0f} s: {differ} differ")  # noqa: T201
    return 1 if differ else 0


if __name__ == "__main__":
    sys.exit(main())
