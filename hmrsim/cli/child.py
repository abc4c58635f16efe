"""Child processes of a command, which end when their parent does.

``python -m hmrsim.cli.child PARENT_PID MODULE:FUNCTION ARGUMENT…`` calls a command's main function with the
arguments. On Linux the kernel sends it SIGTERM when the parent is gone; elsewhere it survives a parent that is killed.
"""

from __future__ import annotations

import ctypes
import importlib
import logging
import os
import signal
import subprocess
import sys
import threading
from collections import deque
from collections.abc import Callable, Sequence
from typing import Final, Self

from hmrsim.program.signals import leave, must_leave

_PR_SET_PDEATHSIG: Final = 1
_ORPHANED: Final = 1

_PATIENCE: Final = 3.0
_DRAIN_TIMEOUT: Final = 1.0
_KEPT_LINES: Final = 50

_log = logging.getLogger(__name__)


class Child:
    """A process in its own process group, so that only the parent handles Ctrl-C on the terminal.

    Its stderr is kept, and logged.

    Args:
        name: The name for threads and errors.
        target: The main function, ``module:function``.
        arguments: The command line.
        on_line: Called with each line of stdout, and with None at its end, in a separate thread.
    """

    def __init__(self, name: str, target: str, arguments: Sequence[str], on_line: Callable[[str | None], None]) -> None:
        self.name = name
        self._errors: deque[str] = deque(maxlen=_KEPT_LINES)
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
            threading.Thread(target=self._read_output, args=(on_line,), name=f"{name} output", daemon=True),
            threading.Thread(target=self._read_errors, name=f"{name} errors", daemon=True),
        ]
        for reader in self._readers:
            reader.start()

    def __enter__(self) -> Self:
        """Return the child."""
        return self

    def __exit__(self, *_error: object) -> None:
        """Stop the process."""
        self.stop()

    @property
    def errors(self) -> str:
        """The last lines of stderr, without the name of the program."""
        return "\n".join(line.removeprefix("hmrsim: ") for line in self._errors)

    def code(self, timeout: float) -> int:
        """Return the exit code; stop the process if it does not end within *timeout* wall seconds."""
        try:
            self._process.wait(timeout)
        except subprocess.TimeoutExpired:
            self.stop()
        for reader in self._readers:
            reader.join(_DRAIN_TIMEOUT)
        return self._process.returncode

    def stop(self) -> None:
        """Terminate the process and its own children: with SIGTERM, then with SIGKILL."""
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

    def _read_output(self, on_line: Callable[[str | None], None]) -> None:
        for line in self._process.stdout or ():
            on_line(line.rstrip("\n"))
        on_line(None)

    def _read_errors(self) -> None:
        for line in self._process.stderr or ():
            self._errors.append(line.rstrip("\n"))
            _log.info("%s: %s", self.name, self._errors[-1])


def _environment() -> dict[str, str]:
    """Return this process's environment without HMRSIM's variables, which may change where a child connects."""
    return {name: value for name, value in os.environ.items() if not name.startswith("HMRSIM_")}


def main(argv: Sequence[str]) -> int:
    """Run a command as a child process and return its exit code.

    Args:
        argv: The parent's process id, ``module:function``, and the arguments of the command.
    """
    parent, target, *arguments = argv
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
    if os.getppid() != int(parent):
        return _ORPHANED
    module, _, function = target.partition(":")
    code: int = getattr(importlib.import_module(module), function)(arguments)
    return code


if __name__ == "__main__":
    exit_code = main(sys.argv[1:])
    if must_leave(exit_code):
        leave(exit_code)
    sys.exit(exit_code)
