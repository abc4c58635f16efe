"""Runs that should all be the same: real processes, disturbed as much as an ordinary machine can."""

from __future__ import annotations

import hashlib
import sys
from contextlib import ExitStack
from typing import TYPE_CHECKING

from benchmarks._processes import HMRSIM, ROOT, command, line_of

if TYPE_CHECKING:
    import subprocess
    from contextlib import AbstractContextManager
    from pathlib import Path

_CONTROLLER = str(ROOT / "tests" / "system" / "controller.py")
_ROBOTS = ("wall_e", "eve", "burn_e", "m_o")
_PATIENCE = 60.0


def distinct_traces(controllers: int, runs: int, folder: Path) -> int:
    """Return how many different traces some runs of the hospital have; one is what it should be.

    Controllers start in any order and think for random times, hash seeds differ, and another process keeps a core
    busy.
    """
    with command(sys.executable, "-c", "while True: pass"):
        return len({_digest(number, controllers, folder / "trace.jsonl") for number in range(runs)})


def _digest(number: int, controllers: int, trace: Path) -> str:
    """Return the SHA-256 of the trace of one run."""
    options = ("--clock", "lockstep", "--participants", str(controllers), "--trace", str(trace))
    words = (*HMRSIM, "run", "hospital", *options, "--listen", "tcp/127.0.0.1:0", "--log-level", "error")
    with command(*words, PYTHONHASHSEED=str(number)) as simulator, ExitStack() as stack:
        endpoint = line_of(simulator).split()[1]
        started = [
            stack.enter_context(_controller(endpoint, (number + index) % controllers, controllers, number))
            for index in range(controllers)
        ]
        for process in started:
            if code := process.wait(_PATIENCE):
                raise RuntimeError(f"{process.args!r} ended with {code}")
    return hashlib.sha256(trace.read_bytes()).hexdigest()


def _controller(
    endpoint: str, index: int, controllers: int, number: int
) -> AbstractContextManager[subprocess.Popen[str]]:
    """Start a controller that has its share of the robots."""
    robots = ",".join(_ROBOTS[index::controllers])
    words = (sys.executable, _CONTROLLER, endpoint, f"controller_{index}", robots, "--pause", "0.01")
    return command(*words, PYTHONHASHSEED=str(1000 * number + index))
