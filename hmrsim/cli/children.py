"""Child processes of a command: their output and their termination."""

from __future__ import annotations

import logging
import os
import signal
import subprocess
import sys
import threading
from collections import deque
from collections.abc import Callable, Sequence
from typing import Final, Self

_PATIENCE: Final = 3.0
_DRAIN_TIMEOUT: Final = 1.0
_KEPT_LINES: Final = 50

_log = logging.getLogger(__name__)


class Child:
    """A process in a group of its own, so that the parent handles Ctrl-C on the terminal.

    Its stderr is kept, and logged.

    Args:
        name: Its name in threads and errors.
        target: Its main function, ``module:function``.
        arguments: Of its command line.
        on_line: Called with each line of its output, and with None at the end of it, in a thread of its own.
    """

    def __init__(self, name: str, target: str, arguments: Sequence[str], on_line: Callable[[str | None], None]) -> None:
        self.name = name
        self._complaints: deque[str] = deque(maxlen=_KEPT_LINES)
        self._process = subprocess.Popen(  # noqa: S603 - ourselves
            [sys.executable, "-m", "hmrsim.cli.child", str(os.getpid()), target, *arguments],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            errors="replace",
            start_new_session=True,
            env=_environment(),
        )
        self._readers = [
            threading.Thread(target=self._read, args=(on_line,), name=f"{name} output", daemon=True),
            threading.Thread(target=self._listen, name=f"{name} errors", daemon=True),
        ]
        for reader in self._readers:
            reader.start()

    def __enter__(self) -> Self:
        """Return the child."""
        return self

    def __exit__(self, *_error: object) -> None:
        """End it."""
        self.stop()

    @property
    def complaints(self) -> str:
        """The last lines of its stderr."""
        return "\n".join(self._complaints)

    @property
    def said(self) -> str:
        """The last lines of its stderr without the name of the program, to be told by another."""
        return "\n".join(line.removeprefix("hmrsim: ") for line in self._complaints)

    def code(self, timeout: float) -> int:
        """Return its exit code; terminate it if it does not end by itself within *timeout* wall seconds."""
        try:
            self._process.wait(timeout)
        except subprocess.TimeoutExpired:
            self.stop()
        for reader in self._readers:
            reader.join(_DRAIN_TIMEOUT)
        return self._process.returncode

    def stop(self) -> None:
        """Terminate it and its own children, by SIGTERM first."""
        if self._process.poll() is None:
            self._signal(signal.SIGTERM)
            try:
                self._process.wait(_PATIENCE)
            except subprocess.TimeoutExpired:
                self._signal(signal.SIGKILL)
                self._process.wait(_PATIENCE)
        for stream, reader in zip((self._process.stdout, self._process.stderr), self._readers, strict=True):
            reader.join(_DRAIN_TIMEOUT)
            if stream is not None and not reader.is_alive():
                stream.close()

    def _signal(self, number: signal.Signals) -> None:
        try:
            os.killpg(self._process.pid, number)
        except ProcessLookupError:
            return

    def _read(self, on_line: Callable[[str | None], None]) -> None:
        for line in self._process.stdout or ():
            on_line(line.rstrip("\n"))
        on_line(None)

    def _listen(self) -> None:
        for line in self._process.stderr or ():
            self._complaints.append(line.rstrip("\n"))
            _log.info("%s: %s", self.name, self._complaints[-1])


def _environment() -> dict[str, str]:
    """Return this process's environment without the variables that change where a child connects or listens."""
    return {name: value for name, value in os.environ.items() if not name.startswith("HMRSIM_")}
