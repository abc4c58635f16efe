"""A simulator process, and measurements of its memory, its answers and its end."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO, TYPE_CHECKING, Final

from hmrsim_zenoh.wire.options import SessionOptions
from hmrsim_zenoh.wire.session import open_client

if TYPE_CHECKING:
    import zenoh

HMRSIM: Final = (sys.executable, "-m", "hmrsim.cli")
_END_SECONDS: Final = 30.0
_KIB: Final = 1024


@dataclass
class Simulator:
    """A process that runs a world.

    Attributes:
        process: The process.
        endpoint: Where it listens.
        log: Its log, line by line.
    """

    process: subprocess.Popen[str]
    endpoint: str
    log: Path

    def session(self) -> zenoh.Session:
        return open_client(SessionOptions(connect=(self.endpoint,)))

    def memory(self) -> int:
        """Return the bytes of memory that it has allocated (Linux)."""
        return allocated(self.process.pid)

    @property
    def runs(self) -> bool:
        return self.process.poll() is None

    def end(self) -> float:
        """Interrupt it; return the wall seconds until it has ended.

        Raises:
            RuntimeError: It does not end, or not with exit code 0.
        """
        began = time.perf_counter()
        self.process.send_signal(signal.SIGINT)
        try:
            code = self.process.wait(_END_SECONDS)
        except subprocess.TimeoutExpired:
            raise RuntimeError(f"it has not ended {_END_SECONDS:g} s after SIGINT") from None
        if code:
            raise RuntimeError(f"it ended with exit code {code}")
        return time.perf_counter() - began


def allocated(process: int | str) -> int:
    """Return the bytes of memory that a process has allocated, by its id or as ``self`` (Linux).

    Pages of libraries do not count: they become its own, or shared, as other processes that read them come and go.
    """
    lines = Path(f"/proc/{process}/smaps_rollup").read_text().splitlines()
    return _KIB * next(int(line.split()[1]) for line in lines if line.startswith("Anonymous"))


@contextmanager
def simulator(world: Path, log: Path, *options: str) -> Iterator[Simulator]:
    """Run a world on a free port of this machine until the block ends."""
    words = (*HMRSIM, "run", str(world), "--listen", "tcp/127.0.0.1:0", "--log-level", "error", *options)
    with log.open("w") as errors, _started(words, errors) as process:
        yield Simulator(process, _endpoint(process), log)


@contextmanager
def _started(words: tuple[str, ...], errors: IO[str]) -> Iterator[subprocess.Popen[str]]:
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=errors, text=True) as process:
        try:
            yield process
        finally:
            process.kill()


def _endpoint(process: subprocess.Popen[str]) -> str:
    """Return the endpoint in the first line."""
    if process.stdout is None:
        raise AssertionError
    line = process.stdout.readline()
    found = next((word for word in line.replace(",", " ").split() if word.startswith("tcp/")), None)
    if found is None:
        raise RuntimeError(f"the simulator is not ready: {line!r}")
    return found
