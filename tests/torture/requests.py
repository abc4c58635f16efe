"""``python -m tests.torture.requests [--count N] [--seed S]``: send invalid requests, JSON and CDR.

Each is answered, in time, by what its type says or by an error in plain words; each accepted goal ends, once.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import Any, Final

import zenoh

from hmrsim_zenoh.ros2.wires import Attachment
from tests.torture._made_requests import Fleet, Made, Maker
from tests.torture._simulator import Simulator, simulator

WORLD_FILE: Final = {
    "waypoints": {"home": [1, 2], "door": [5, 2], "shelf": [9, 2]},
    "lanes": [["home", "door"], ["door", "shelf"]],
    "items": {"parcel": {"at": [9, 2.3]}},
    "docks": {"berth": {"at": "home"}},
    "robot_types": {
        "nurse": {
            "base": {"turning_rate": 1.0, "acceleration": 0.5},
            "components": {"claw": {}, "camera": {}, "battery": {"capacity": 1e6, "drain": {"default": 1}}},
        }
    },
    "robots": {"wall_e": {"type": "nurse", "at": "home"}, "eve": {"type": "nurse", "at": "shelf"}},
    "traffic": {"policy": "reserve"},
}
FLEET: Final = Fleet(
    ("wall_e", "eve"), ("wall_e", "eve", "parcel", "berth", "home", "map", "", "breakdown", "slip", "robot_type:nurse")
)

_WINDOW: Final = 64
"""Requests on their way at once."""
_ROUND: Final = 1_000
"""Requests after which all goals have to end."""
_PATIENCE: Final = 20.0
"""Wall seconds for an answer, and for the end of goals that are canceled."""
_MAX_TEXT: Final = 20_000
"""Characters of an error reply."""
_PRINTED: Final = 300
_KIND: Final = 60
_GID: Final = bytes(range(16))


@dataclass
class Ledger:
    """The outcomes of all requests so far.

    Attributes:
        answers: Counts kinds of answers.
        flaws: Unexpected answers, in words.
        slowest: The longest wait for an answer in wall seconds.
    """

    answers: Counter[str] = field(default_factory=Counter)
    flaws: list[str] = field(default_factory=list)
    slowest: float = 0.0


class Sender:
    """Sends requests, some at once, and keeps a ledger."""

    def __init__(self, session: zenoh.Session, ledger: Ledger) -> None:
        self._session = session
        self._ledger = ledger
        self._room = threading.Semaphore(_WINDOW)
        self._lock = threading.Lock()
        self._sequence = 0
        self._waiting: dict[str, Made] = {}
        """The accepted goals that have not ended, by their ids."""
        self._results: dict[str, Made] = {}
        """The goals whose result came before it was known that they were accepted."""
        self._ended = threading.Condition(self._lock)

    def send(self, made: Made) -> None:
        self._room.acquire()
        began, answers = time.perf_counter(), []

        def take(reply: zenoh.Reply) -> None:
            answers.append(reply)

        def end() -> None:
            try:
                self._note(made, answers, time.perf_counter() - began)
            finally:
                self._room.release()

        self._get(made.key, made.payload, zenoh.handlers.Callback(take, end, indirect=False), ros=made.ros)
        if made.result_key:
            self._follow(made)

    def settle(self) -> None:
        """Advance time and cancel goals until all have ended."""
        for _ in range(_WINDOW):
            self._room.acquire()
        self._room.release(_WINDOW)
        for key, values in (
            ("time/set", {"clock": "realtime", "real_time_factor": 0}),
            ("set_simulation_state", {"state": {"state": 1}}),
        ):
            self._ask(f"{FLEET.prefix}/_world/{key}", values)
        with self._lock:
            left = {made.result_key: made for made in self._waiting.values()}
        for robot, action in dict.fromkeys(tuple(_of(made)) for made in left.values()):
            self._ask(f"{FLEET.prefix}/{robot}/{action}/_action/cancel_goal", {})
        with self._ended:
            if not self._ended.wait_for(lambda: not self._waiting, _PATIENCE):
                self._ledger.flaws += [f"has not ended: {_shown(made)}" for made in self._waiting.values()]
                self._waiting.clear()
            self._results.clear()
        self._ask(f"{FLEET.prefix}/_world/reset_simulation", {})

    def _ask(self, key: str, values: Any) -> None:
        for reply in self._session.get(key, payload=json.dumps(values), timeout=_PATIENCE):
            if reply.ok is not None:
                return
        self._ledger.flaws.append(f"no answer to {key} {values}")

    def _get(self, key: str, payload: bytes, handler: Any, *, ros: bool) -> None:
        options: dict[str, Any] = {}
        if ros:
            self._sequence += 1
            options["attachment"] = Attachment(self._sequence, 1, _GID).to_bytes()
        # get_result is answered when the goal ends, which may be after many rounds of requests.
        self._session.get(key, handler, payload=payload, timeout=10 * _PATIENCE, **options)

    def _note(self, made: Made, answers: list[zenoh.Reply], seconds: float) -> None:
        try:
            kind, accepted = _judged(made, answers, seconds)
        except Exception as error:  # noqa: BLE001 - whatever the reply is
            kind, accepted = f"{type(error).__name__}: {error}", False
            self._flaw(made, kind)
        with self._ended:
            self._ledger.answers[kind[:_KIND]] += 1
            self._ledger.slowest = max(self._ledger.slowest, seconds)
            if accepted and self._results.pop(made.goal_id, None) is None:
                self._waiting[made.goal_id] = made

    def _follow(self, made: Made) -> None:
        """Request a goal's result right after it; the reply means nothing if the goal was rejected."""
        ends: list[zenoh.Reply] = []

        def end() -> None:
            with self._ended:
                accepted = self._waiting.pop(made.goal_id, None) is not None
                if not accepted:
                    self._results[made.goal_id] = made
                self._ended.notify_all()
            if accepted and not _told(ends):
                self._flaw(made, f"{len(ends)} results")

        handler = zenoh.handlers.Callback(ends.append, end, indirect=False)
        self._get(made.result_key, made.result_payload, handler, ros=made.ros)

    def _flaw(self, made: Made, what: str) -> None:
        with self._lock:
            self._ledger.flaws.append(f"{what[:_PRINTED]}: {_shown(made)}")


def _judged(made: Made, answers: list[zenoh.Reply], seconds: float) -> tuple[str, bool]:
    """Return the kind of an answer, and whether it accepts a goal.

    Raises:
        ValueError: It is no answer to this request.
    """
    if seconds > _PATIENCE:
        raise ValueError(f"answered after {seconds:.1f} s")
    if len(answers) != 1:
        raise ValueError(f"{len(answers)} answers")
    (reply,) = answers
    if reply.ok is not None:
        accepted = made.reads(reply.ok.payload.to_bytes())
        return ("ROS reply" if made.ros else "JSON reply"), accepted and bool(made.goal_id)
    text = "" if reply.err is None else reply.err.payload.to_string()
    if made.ros:
        raise ValueError(f"an error reply, for which a ROS client waits forever: {text}")
    error = json.loads(text)["error"]
    if not error or len(text) > _MAX_TEXT or not text.isprintable() or "bug" in error:
        raise ValueError(f"not clear: {text}")
    return "JSON error", False


def _told(ends: list[zenoh.Reply]) -> bool:
    """Return whether an accepted goal's result request had exactly one answer."""
    if len(ends) != 1:
        return False
    (reply,) = ends
    # Its robot may have been deleted by another request.
    return reply.ok is not None or (reply.err is not None and "no robot" in reply.err.payload.to_string())


def _of(made: Made) -> Iterator[str]:
    """Yield robot and action of a goal."""
    parts = made.result_key.split("/")
    if not made.ros:
        yield from parts[1:3]
    elif parts[2] == "_action":
        yield from ("_world", parts[1])
    else:
        yield from parts[1:3]


def _shown(made: Made) -> str:
    return f"{made.key} {made.payload[:_PRINTED]!r}"


def torture(running: Simulator, count: int, seed: int, *, told: bool = False) -> Ledger:
    """Send *count* requests to a simulator of `WORLD_FILE`; return what came of them."""
    ledger = Ledger()
    requests = iter(Maker(FLEET, seed))
    with running.session() as session:
        sender = Sender(session, ledger)
        for number in range(0, count, _ROUND):
            for made in islice(requests, min(_ROUND, count - number)):
                sender.send(made)
            sender.settle()
            if not running.runs:
                ledger.flaws.append(f"the simulator has ended, after {number} requests")
                break
            if told and number % (10 * _ROUND) == 0:
                sys.stderr.write(f"{number + _ROUND:,}: {running.memory() / 1e6:.1f} MB, {len(ledger.flaws)} flaws\n")
    return ledger


def main(argv: Sequence[str] | None = None) -> int:
    """Return 0 if all was answered well."""
    parser = argparse.ArgumentParser(prog="python -m tests.torture.requests", description=__doc__)
    parser.add_argument("--count", type=int, default=1_000_000)
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args(argv)
    with tempfile.TemporaryDirectory() as folder:
        world, log = Path(folder) / "world.json", Path(folder) / "log.txt"
        world.write_text(json.dumps(WORLD_FILE))
        with simulator(world, log, "--real-time-factor", "0", "--ros2") as running:
            ledger = torture(running, args.count, args.seed, told=True)
            took = running.end() if running.runs else 0.0
        sys.stdout.write("".join(f"{number:>9,} {kind}\n" for kind, number in ledger.answers.most_common()))
        sys.stdout.write(f"slowest answer {ledger.slowest:.2f} s, end {took:.2f} s, log {log.stat().st_size:,} bytes\n")
        sys.stdout.writelines(f"{flaw}\n" for flaw in ledger.flaws[:50])
        sys.stdout.write(log.read_text()[-3_000:])
    return 1 if ledger.flaws else 0


if __name__ == "__main__":
    sys.exit(main())
