"""The time that the simulator takes to start."""

from __future__ import annotations

import subprocess
import sys
from contextlib import ExitStack
from functools import partial
from typing import Any

from benchmarks._processes import ENVIRONMENT, HMRSIM, ROOT, command, free_port, line_of
from benchmarks._report import Row
from benchmarks._timing import Variant, interleaved

QUICK: dict[str, Any] = {"rounds": 1}

_LIMITS = {
    "hmrsim --help": 0.3,
    "hmrsim run scenario2 until ready": 0.25,
    "with hmrsim_zenoh.Client until its first goal": 0.33,
    "with a bare Zenoh client until its first goal": 0.33,
}


def run(*, rounds: int = 11) -> list[Row]:
    """Return the wall seconds until each of these has said what it was started for."""
    begun = ExitStack()
    variants = [
        Variant("python -c pass", partial(_run, sys.executable, "-c", "pass")),
        Variant("hmrsim --help", partial(_run, *HMRSIM, "--help")),
        Variant("hmrsim run scenario2 until ready", partial(_until_ready, begun), begun.close),
        Variant("with hmrsim_zenoh.Client until its first goal", partial(_first_goal, "client", begun), begun.close),
        Variant("with a bare Zenoh client until its first goal", partial(_first_goal, "bare", begun), begun.close),
    ]
    took = interleaved(variants, rounds)
    return [Row(name, took.spread(name), "s", at_most=_LIMITS.get(name)) for name in took.taken]


def _run(*words: str) -> None:
    subprocess.run(words, cwd=ROOT, env=ENVIRONMENT, stdout=subprocess.DEVNULL, check=True)


def _until_ready(begun: ExitStack) -> None:
    line_of(begun.enter_context(command(*HMRSIM, "run", "scenario2", "--listen", "tcp/127.0.0.1:0")))


def _first_goal(by: str, begun: ExitStack) -> None:
    """Start both at once, and return when the controller's first goal is accepted."""
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    begun.enter_context(command(*HMRSIM, "run", "scenario2", "--listen", endpoint))
    line_of(begun.enter_context(command(sys.executable, "-m", "benchmarks._first_goal", endpoint, by)))
