"""Controllers that are commands: processes, and how they end."""

from __future__ import annotations

import os
import signal
import subprocess
import threading
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import IO, TYPE_CHECKING, Final, Self

from hmrsim.experiments.judging.labels import CRASHED, HUNG, TIMEOUT
from hmrsim.experiments.running.controlling import FAILED, SUCCEEDED, TimeLimit
from hmrsim.experiments.running.guards import Tail

if TYPE_CHECKING:
    from pathlib import Path

    from hmrsim_zenoh.hosting.host import Host

GRACE: Final = 2.0
"""Wall seconds that a controller has to end by itself after the run has ended."""
POLL: Final = 0.002
"""Wall seconds between two looks whether the controller, or the run, has ended."""
_FAILED: Final = 1
"""The exit code of a controller that has failed, and not crashed."""


class ControllerProcess:
    """The process of a controller, and all that it starts; a context manager that kills them.

    Args:
        words: The command.
        folder: Where it is started.
        variables: What its environment has beside that of this process.

    Raises:
        OSError: It can't be started.
    """

    def __init__(self, words: Sequence[str], folder: Path, variables: Mapping[str, str]) -> None:
        self._tail = Tail()
        self._process = subprocess.Popen(  # noqa: S603 - the user's own command
            words,
            cwd=folder,
            env=os.environ | variables,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            start_new_session=True,
            text=True,
            errors="replace",
        )
        self._reader = threading.Thread(target=self._read, args=(self._process.stdout,), daemon=True)
        self._reader.start()

    def __enter__(self) -> Self:
        """Return it."""
        return self

    def __exit__(self, *_error: object) -> None:
        """Kill it, and read what it has printed."""
        self.kill()
        self._reader.join(GRACE)

    def kill(self) -> None:
        """Kill it, and all that it has started, at once."""
        with suppress(ProcessLookupError):
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()

    @property
    def code(self) -> int | None:
        """The exit code; None while it runs."""
        return self._process.poll()

    @property
    def output(self) -> str:
        """The end of what it has printed."""
        return self._tail.text

    def _read(self, stream: IO[str]) -> None:
        with suppress(ValueError, OSError), stream:
            while text := stream.read(4096):
                self._tail.write(text)


def follow(controller: ControllerProcess, host: Host) -> tuple[str, str]:
    """Wait for the end of a controller, or of the run; return its ending, and the cause if it has not ended by itself.

    It is that of a run whose time is over if `TimeLimit` is raised meanwhile.
    """
    try:
        while (code := controller.code) is None:
            if host.wait(POLL):
                wait_for_end(controller)
                return TIMEOUT, ""
    except TimeLimit as limit:
        return HUNG, str(limit)
    return ending_of(code)


def wait_for_end(controller: ControllerProcess) -> None:
    """Give a controller some time to end after the run has ended."""
    deadline = time.monotonic() + GRACE
    while controller.code is None and time.monotonic() < deadline:
        time.sleep(POLL)


def ending_of(code: int) -> tuple[str, str]:
    """Return the ending that an exit code stands for, and the cause of a crash."""
    if code == 0:
        return SUCCEEDED, ""
    if code == _FAILED:
        return FAILED, ""
    return CRASHED, f"the controller ended with {f'signal {-code}' if code < 0 else f'exit code {code}'}"
