"""``python -m tests.torture.soak [--minutes M] [--clients N]``: random clients for an hour, and what that costs.

Fails if memory still grows after the first sixth of the time, if answers come later than at first, if an accepted
goal does not end, or if the simulator takes long to end.
"""

from __future__ import annotations

import argparse
import json
import random
import statistics
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Final

import zenoh

from tests.torture._simulator import Simulator, simulator

ROBOTS: Final = tuple(f"robot_{number}" for number in range(10))
SIDE: Final = 5
PREFIX: Final = "hmrsim"

_PATIENCE: Final = 30.0
_MAX_GROWTH: Final = 2e6
"""Bytes an hour, after the first sixth of the time."""
_MAX_END: Final = 1.0
_MAX_SLOWER: Final = 1.5
"""The 99th percentile of the last sixth, against that of the second sixth."""
_PARTS: Final = 6
_PROBE: Final = 0.02
_SAMPLE: Final = 5.0
_IGNORE: Final[Any] = zenoh.handlers.Callback(lambda _: None, indirect=False)


def world() -> dict[str, Any]:
    """Return a grid with robots that share its lanes."""
    points = {f"w{x}{y}": [6.0 * x, 6.0 * y] for x in range(SIDE) for y in range(SIDE)}
    across = [[f"w{x}{y}", f"w{x + 1}{y}"] for x in range(SIDE - 1) for y in range(SIDE)]
    along = [[f"w{x}{y}", f"w{x}{y + 1}"] for x in range(SIDE) for y in range(SIDE - 1)]
    starts = list(points)
    return {
        "waypoints": points,
        "lanes": [*across, *along],
        "items": {"parcel": {"at": [6.0, 6.3]}},
        "robot_types": {"nurse": {"components": {"claw": {}, "camera": {}}}},
        "robots": {robot: {"type": "nurse", "at": starts[2 * number]} for number, robot in enumerate(ROBOTS)},
        "traffic": {"policy": "priority"},
    }


class Client(threading.Thread):
    """A client that acts at random, and sometimes replaces its session."""

    def __init__(self, running: Simulator, seed: int, over: threading.Event) -> None:
        super().__init__(daemon=True)
        self._running = running
        self._chance = random.Random(seed)
        self._over = over
        self._number = seed
        self.done: Counter[str] = Counter()
        self.flaws: list[str] = []

    def run(self) -> None:
        deeds: Sequence[Callable[[zenoh.Session], None]] = (
            *(self._goal,) * 12,
            *(self._reading,) * 6,
            *(self._listening,) * 3,
            self._entity,
            self._fault,
            self._rejected,
        )
        while not self._over.is_set():
            with self._running.session() as session:
                for _ in range(self._chance.randrange(50, 500)):
                    if self._over.is_set():
                        break
                    deed = self._chance.choice(deeds)
                    deed(session)
                    self.done[deed.__name__.lstrip("_")] += 1

    def _ask(self, session: zenoh.Session, key: str, values: Any = None) -> Any:
        """Return the first answer, and record its absence."""
        payload = None if values is None else json.dumps(values)
        for reply in session.get(f"{PREFIX}/{key}", payload=payload, timeout=_PATIENCE):
            if reply.ok is not None:
                return json.loads(reply.ok.payload.to_string())
            return {}
        self.flaws.append(f"no answer to {key} {payload}")
        return {}

    def _goal(self, session: zenoh.Session) -> None:
        """Send a goal and wait for its end; cancel it sometimes, and always when it takes too long."""
        robot, chance = self._chance.choice(ROBOTS), self._chance
        x, y = (6.0 * chance.randrange(SIDE) for _ in range(2))
        action, goal = chance.choice(
            (
                ("navigate_to_pose", {"pose": {"pose": {"position": {"x": x, "y": y}}}}),
                ("navigate_to_pose", {"pose": {"pose": {"position": {"x": x, "y": y}}}}),
                ("wait", {"time": {"sec": chance.randrange(4)}}),
                ("spin", {"target_yaw": chance.uniform(-3, 3)}),
                ("compute_path_to_pose", {"goal": {"pose": {"position": {"x": x, "y": y}}}}),
            )
        )
        goal_id, key = f"{chance.getrandbits(128):032x}", f"{robot}/{action}/_action"
        if not self._ask(session, f"{key}/send_goal", {"goal_id": goal_id, "goal": goal}).get("accepted"):
            return
        answered, over = threading.Event(), threading.Event()
        handler: Any = zenoh.handlers.Callback(lambda _: answered.set(), over.set, indirect=False)
        wanted = json.dumps({"goal_id": goal_id})
        session.get(f"{PREFIX}/{key}/get_result", handler, payload=wanted, timeout=10 * _PATIENCE)
        if not over.wait(chance.choice((0.01, 0.2, 0.5))):
            self._ask(session, f"{key}/cancel_goal", {"goal_info": {"goal_id": goal_id}})
            over.wait(_PATIENCE)
        if not answered.is_set():
            self._miss(session, key, goal_id, lost=over.is_set())

    def _miss(self, session: zenoh.Session, key: str, goal_id: str, *, lost: bool) -> None:
        """Request a missing result again; it is no flaw if Zenoh *lost* the first request."""
        self.done["lost"] += lost
        result = self._ask(session, f"{key}/get_result", {"goal_id": goal_id})
        if not (lost and result.get("result")):
            known = [
                each["status"]
                for each in self._ask(session, f"{key}/status").get("status_list", ())
                if goal_id in str(each)
            ]
            self.flaws.append(
                f"{key} {goal_id} has not ended (lost: {lost}); its status is {known}; asked again: {result}"
            )

    def _reading(self, session: zenoh.Session) -> None:
        self._ask(session, self._chance.choice(("robot_3/odom", "*/odom", "_world/info", "*/wait/_action/status")))

    def _listening(self, session: zenoh.Session) -> None:
        key = self._chance.choice(("*/odom", "_world/*", "robot_1/**", "**", "*/*/_action/feedback"))
        subscriber = session.declare_subscriber(f"{PREFIX}/{key}", _IGNORE)
        self._over.wait(self._chance.choice((0.0, 0.1, 1.0)))
        subscriber.undeclare()

    def _entity(self, session: zenoh.Session) -> None:
        name = f"guest_{self._number}_{self.done.total()}"
        position = {"x": self._chance.uniform(0.0, 24.0), "y": 30.0 + self._number}
        request = {"name": name, "uri": "robot_type:nurse", "initial_pose": {"pose": {"position": position}}}
        self._ask(session, "_world/spawn_entity", request)
        self._ask(session, "_world/delete_entity", {"entity": name})

    def _fault(self, session: zenoh.Session) -> None:
        robot = self._chance.choice(ROBOTS)
        self._ask(session, "_world/inject_fault", {"type": "breakdown", "robot": robot, "duration": 1.0})

    def _rejected(self, session: zenoh.Session) -> None:
        goal_id = f"{self._chance.getrandbits(128):032x}"
        self._ask(session, "nobody/wait/_action/send_goal", {"goal_id": goal_id, "goal": {}})


class Probe(threading.Thread):
    """Measures response times and memory continuously."""

    def __init__(self, running: Simulator, over: threading.Event) -> None:
        super().__init__(daemon=True)
        self._running = running
        self._over = over
        self.answers: list[tuple[float, float]] = []
        self.memory: list[tuple[float, int]] = []

    def run(self) -> None:
        began = time.perf_counter()
        with self._running.session() as session:
            while not self._over.wait(_PROBE):
                asked = time.perf_counter()
                list(session.get(f"{PREFIX}/robot_0/odom", timeout=_PATIENCE))
                now = time.perf_counter()
                self.answers.append((now - began, now - asked))
                if not self.memory or now - began > self.memory[-1][0] + _SAMPLE:
                    self.memory.append((now - began, self._running.memory()))


def soak(running: Simulator, seconds: float, clients: int) -> tuple[list[Client], Probe]:
    """Run clients of a simulator of `world` for some time."""
    over = threading.Event()
    threads = [Client(running, seed, over) for seed in range(clients)]
    probe = Probe(running, over)
    for thread in (*threads, probe):
        thread.start()
    end = time.perf_counter() + seconds
    while time.perf_counter() < end and running.runs:
        time.sleep(min(60.0, seconds / _PARTS))
        deeds = sum((client.done for client in threads), Counter())
        size = probe.memory[-1][1] / 1e6 if probe.memory else 0.0
        sys.stderr.write(
            f"{probe.memory[-1][0] if probe.memory else 0:7.0f} s: {size:.1f} MB, {deeds.total():,} deeds\n"
        )
    over.set()
    for thread in (*threads, probe):
        thread.join(2 * _PATIENCE)
    return threads, probe


def growth(memory: Sequence[tuple[float, int]]) -> float:
    """Return the growth of memory in bytes per hour, as the slope of the line through all samples."""
    slope, _ = statistics.linear_regression(*zip(*memory, strict=True))
    return 3600.0 * slope


def quantile(answers: Sequence[tuple[float, float]], begin: float, end: float) -> float:
    """Return the 99th percentile of response times in a part of the time, in seconds."""
    chosen = [took for at, took in answers if begin <= at < end]
    return statistics.quantiles(chosen, n=100)[-1]


def main(argv: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.torture.soak", description=__doc__)
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--clients", type=int, default=8)
    args = parser.parse_args(argv)
    seconds = 60.0 * args.minutes
    with tempfile.TemporaryDirectory() as folder:
        file, log = Path(folder) / "world.json", Path(folder) / "log.txt"
        file.write_text(json.dumps(world()))
        with simulator(file, log, "--real-time-factor", "20", "--ros2") as running:
            clients, probe = soak(running, seconds, args.clients)
            flaws = [flaw for client in clients for flaw in client.flaws]
            if not running.runs:
                flaws.append("the simulator has ended")
            took = running.end() if running.runs else 0.0
        told = log.read_text()
    grown = growth([each for each in probe.memory if each[0] > seconds / _PARTS])
    first, last = (quantile(probe.answers, *(seconds * at / _PARTS for at in part)) for part in ((1, 2), (5, 6)))
    deeds = sum((client.done for client in clients), Counter())
    sys.stdout.write(f"{deeds.total():,} deeds: {dict(deeds)}\n")
    sys.stdout.write(f"memory {probe.memory[-1][1] / 1e6:.1f} MB, grows by {grown / 1e6:+.2f} MB an hour\n")
    sys.stdout.write(f"99th percentile of an answer {first * 1e3:.1f} ms, at last {last * 1e3:.1f} ms\n")
    sys.stdout.write(f"end {took:.2f} s, log {len(told):,} bytes\n{told[-2_000:]}")
    flaws += ["a traceback in the log"] * ("Traceback" in told)
    flaws += ["memory grows"] * (grown > _MAX_GROWTH) + ["slow end"] * (took > _MAX_END)
    flaws += ["answers come later than at first"] * (last > _MAX_SLOWER * first)
    sys.stdout.writelines(f"{flaw}\n" for flaw in flaws[:50])
    return 1 if flaws else 0


if __name__ == "__main__":
    sys.exit(main())
