"""Runs that should all be the same: real processes, disturbed as much as an ordinary machine can.

In each run the hospital is shared by some controllers in lockstep, and its trace has to be the same to the byte.
"""

from __future__ import annotations

import hashlib
import random
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import zenoh

from benchmarks._processes import PATIENCE, ROOT, command, line_of
from benchmarks._report import Row
from hmrsim_zenoh.wire.options import SessionOptions
from hmrsim_zenoh.wire.session import open_client

if TYPE_CHECKING:
    import subprocess
    from contextlib import AbstractContextManager

QUICK: dict[str, Any] = {"runs": 2}

_CONTROLLER: Final = str(ROOT / "tests" / "system" / "controller.py")
_ROBOTS: Final = ("wall_e", "eve", "burn_e", "m_o")
_LISTENED: Final = (
    "hmrsim/_world/events",
    "hmrsim/_world/clock",
    "hmrsim/*/odom",
    "hmrsim/*/battery_state",
    "hmrsim/*/*/_action/feedback",
    "hmrsim/**",
)
_BATCHES: Final = (1, 2, 3, 16, 1000)
"""Events that the simulator takes between two looks at its inbox."""
_SIMULATOR: Final = """
import sys
from hmrsim.simulation import simulator
from hmrsim.timing import pacing
from hmrsim.cli import main
simulator._BATCH = pacing._EVENTS_BETWEEN_POLLS = pacing._EVENTS_OF_A_GRANT = int(sys.argv.pop(1))
main()
"""
_IGNORE: Final[zenoh.handlers.Callback[zenoh.Sample]] = zenoh.handlers.Callback(lambda _sample: None, indirect=False)


def run(*, controllers: Sequence[int] = (1, 2, 3), runs: int = 67) -> list[Row]:
    """Return how many different traces some *runs* of each number of controllers have."""
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for number in controllers:
            found = distinct_traces(number, runs, Path(folder))
            name = f"{number} controller{'s' * (number > 1)}, {runs} perturbed runs"
            rows.append(Row(name, found, "different traces", at_most=1))
    return rows


def distinct_traces(controllers: int, runs: int, folder: Path) -> int:
    """Return how many different traces some runs of the hospital have; one is what it should be.

    Controllers start in any order and think for random times, hash seeds differ, another process keeps a core busy,
    a client listens to some topics or to all for the whole run or a part of it, and the simulator looks at its inbox
    after more events or fewer.
    """
    with command(sys.executable, "-c", "while True: pass"):
        return len({_digest(number, controllers, folder / "trace.jsonl") for number in range(runs)})


def _digest(number: int, controllers: int, trace: Path) -> str:
    """Return the SHA-256 of the trace of one run."""
    chance = random.Random(number)
    batch = str(chance.choice(_BATCHES))
    options = ("--clock", "lockstep", "--participants", str(controllers), "--trace", str(trace))
    words = ("run", "hospital", *options, "--listen", "tcp/127.0.0.1:0", "--log-level", "error")
    with (
        command(sys.executable, "-c", _SIMULATOR, batch, *words, PYTHONHASHSEED=str(number)) as simulator,
        ExitStack() as stack,
    ):
        endpoint = line_of(simulator).split()[1]
        keys = chance.sample(_LISTENED, chance.randrange(len(_LISTENED) + 1))
        begins, ends = chance.randrange(controllers + 1), chance.random() < 0.5  # noqa: PLR2004 - half of them
        listening = stack.enter_context(_listening(endpoint, keys)) if begins == 0 else None
        started = []
        for index in range(controllers):
            controller = _controller(endpoint, (number + index) % controllers, controllers, number)
            started.append(stack.enter_context(controller))
            if begins == index + 1:
                listening = stack.enter_context(_listening(endpoint, keys))
        if ends and listening is not None:
            # Wherever the run is by now.
            listening.close()
        for process in started:
            if code := process.wait(PATIENCE):
                raise RuntimeError(f"{process.args!r} ended with {code}")
    return hashlib.sha256(trace.read_bytes()).hexdigest()


@contextmanager
def _listening(endpoint: str, keys: Sequence[str]) -> Iterator[zenoh.Session]:
    """Subscribe to keys, and ignore their messages."""
    with open_client(SessionOptions(connect=(endpoint,))) as session:
        for key in keys:
            session.declare_subscriber(key, _IGNORE)
        yield session


def _controller(
    endpoint: str, index: int, controllers: int, number: int
) -> AbstractContextManager[subprocess.Popen[str]]:
    """Start a controller that has its share of the robots."""
    robots = ",".join(_ROBOTS[index::controllers])
    words = (sys.executable, _CONTROLLER, endpoint, f"controller_{index}", robots, "--pause", "0.01")
    return command(*words, PYTHONHASHSEED=str(1000 * number + index))
