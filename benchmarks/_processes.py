"""Processes to be measured: fresh ones of ours, the commands that users start, and what the kernel says of both."""

from __future__ import annotations

import multiprocessing
import os
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from multiprocessing.connection import Connection

ROOT = Path(__file__).parents[1]
HMRSIM = (sys.executable, "-m", "hmrsim.cli")
"""The command ``hmrsim``, of the Python that runs now."""

ENVIRONMENT = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
"""For commands: an installed hmrsim is compiled, so that only the first start takes the time for that."""

PATIENCE = 600.0
"""Wall seconds after which what should have happened is given up, on the slowest machine."""

_MB = 1e6
_WHILE, _IDLE = 0.5, 0.02
"""Seconds between two looks at a process, and the processor time of one that is idle."""


class Child:
    """A process of ours, and its end of a pipe."""

    def __init__(self, process: Any, pipe: Connection) -> None:
        self._process = process
        self._pipe = pipe

    @property
    def pid(self) -> int:
        """The id of the process."""
        return int(self._process.pid)

    def ask(self, question: object) -> Any:
        """Send a question, and return the answer."""
        self._pipe.send(question)
        return self.receive()

    def receive(self) -> Any:
        """Return what the process sends next.

        Raises:
            EOFError: It has ended.
        """
        return self._pipe.recv()


@contextmanager
def child(function: Callable[..., None], *args: object) -> Iterator[Child]:
    """Call *function* with a pipe's end and *args* in a fresh process; the pipe's end of file tells it to end."""
    context = multiprocessing.get_context("spawn")
    here, there = context.Pipe()
    process = context.Process(target=function, args=(there, *args), daemon=True)
    process.start()
    there.close()  # so that a process that dies is the end of the pipe
    try:
        yield Child(process, here)
    finally:
        here.close()
        process.join(PATIENCE)
        if process.is_alive():
            process.kill()


def wait_for_end(pipe: Connection) -> None:
    """Return when the process that started this one wants it to end."""
    try:
        pipe.recv()
    except EOFError:
        return


@contextmanager
def command(*words: str, **variables: str) -> Iterator[subprocess.Popen[str]]:
    """Run a command from the project's folder, with its output in a pipe; end it with SIGTERM."""
    environment = ENVIRONMENT | variables
    process = subprocess.Popen(
        words, cwd=ROOT, env=environment, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    )
    try:
        yield process
    finally:
        process.terminate()
        try:
            process.communicate(timeout=PATIENCE)
        finally:
            process.kill()


def line_of(process: subprocess.Popen[str]) -> str:
    """Return the next line that a command says.

    Raises:
        RuntimeError: It has ended.
    """
    line = process.stdout.readline() if process.stdout else ""
    if not line:
        raise RuntimeError(f"{process.args!r} ended with {process.wait()}, and said nothing")
    return line


def memory(pid: int | str) -> tuple[float, float]:
    """Return the resident and the proportional memory of a process, in MB."""
    sizes = {}
    for line in Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines()[1:]:
        name, _, size = line.partition(":")
        sizes[name] = int(size.split()[0]) * 1024 / _MB
    return sizes["Rss"], sizes["Pss"]


def processor_seconds(pid: int) -> float:
    """Return the processor time that a process has used so far, in all its threads."""
    # As clock_getcpuclockid makes it; /proc has steps of 10 ms.
    return time.clock_gettime(~pid << 3 | 2)


def settle(pid: int) -> None:
    """Wait until a process has used hardly any processor time for a while."""
    before = -1.0
    while (used := processor_seconds(pid)) - before > _IDLE:
        before = used
        time.sleep(_WHILE)


def threads(pid: int | str) -> int:
    """Return how many threads a process has."""
    status = Path(f"/proc/{pid}/status").read_text()
    return int(status.partition("Threads:")[2].split()[0])


def free_port() -> int:
    """Return a free port of this machine."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])
