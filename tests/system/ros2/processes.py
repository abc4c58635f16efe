"""``hmrsim run WORLD --ros2`` as a process."""

from __future__ import annotations

import signal
import socket
import sys
import tempfile
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import yaml

from tests import processes

if TYPE_CHECKING:
    import subprocess
    from collections.abc import Iterator

HMRSIM = Path(sys.executable).with_name("hmrsim")


@dataclass(frozen=True)
class Running:
    """A simulator that runs as a process.

    Attributes:
        process: The process.
        endpoint: Where to connect.
        log: Where its log goes.
    """

    process: subprocess.Popen[str]
    endpoint: str
    log: Path

    @property
    def port(self) -> str:
        return self.endpoint.rpartition(":")[2]

    @property
    def threads(self) -> int:
        status = Path(f"/proc/{self.process.pid}/status").read_text()
        return int(status.partition("Threads:")[2].split()[0])

    @property
    def resident(self) -> float:
        """Its memory in MB, as Linux reports it."""
        status = Path(f"/proc/{self.process.pid}/status").read_text()
        return int(status.partition("VmRSS:")[2].split()[0]) / 1000

    def end(self, number: int = signal.SIGTERM) -> int:
        self.process.send_signal(number)
        return self.process.wait()


@contextmanager
def simulator(world: Any, *arguments: object, endpoint: str = "tcp/127.0.0.1:0") -> Iterator[Running]:
    """Start a simulator; *world* is the name of a shipped one, or the contents of a world file."""
    with tempfile.TemporaryDirectory() as folder, (Path(folder) / "log").open("w") as log:
        if not isinstance(world, str):
            file = Path(folder) / "world.yaml"
            file.write_text(yaml.safe_dump(world))
            world = str(file)
        process = processes.start("hmrsim", "run", world, "--ros2", "--listen", endpoint, *arguments, stderr=log)
        assert process.stdout is not None
        try:
            ready = process.stdout.readline().split()
            assert ready[:1] == ["ready"], Path(log.name).read_text()
            yield Running(process, ready[1], Path(log.name))
        finally:
            process.kill()
            process.communicate()


def free_endpoint() -> str:
    """Return an endpoint whose free port can be used repeatedly."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return f"tcp/127.0.0.1:{probe.getsockname()[1]}"
