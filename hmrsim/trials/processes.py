"""Controllers that are commands: processes, and how they end."""

from __future__ import annotations

import os
import signal
import subprocess
import threading
from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import IO, TYPE_CHECKING, Final

from hmrsim.trials.guards import Tail

if TYPE_CHECKING:
    from pathlib import Path

GRACE: Final = 2.0
"""Wall seconds that a controller has to end by itself after the run has ended."""


class ControllerProcess:
    """The process of a controller, and all that it starts.

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

    def end(self) -> None:
        """Kill it, and read what it has printed."""
        self.kill()
        self._reader.join(GRACE)

    def wait(self, patience: float) -> None:
        """Wait up to so many wall seconds for its end."""
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(patience)

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
