"""A command in another terminal."""

from __future__ import annotations

import signal
import threading
from typing import TYPE_CHECKING

from tests.patience import PATIENCE

if TYPE_CHECKING:
    import subprocess
    from collections.abc import Callable


class Background:
    """A command that runs beside others; a later one with the same *program* replaces it."""

    def __init__(self, process: subprocess.Popen[str], program: str) -> None:
        self.text = ""
        self.program = program
        self._process = process
        self._changed = threading.Condition()
        self._over = False
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def has_printed(self, enough: Callable[[str], bool]) -> bool:
        """Wait until the command has printed enough; return whether it has."""
        with self._changed:
            self._changed.wait_for(lambda: enough(self.text) or self._over, PATIENCE)
            return bool(enough(self.text))

    def stop(self) -> None:
        """Interrupt the command as Ctrl-C does."""
        self._process.send_signal(signal.SIGINT)
        self._process.wait()
        self._reader.join(PATIENCE)
        self._process.stdout.close()

    def _read(self) -> None:
        for line in self._process.stdout:
            with self._changed:
                self.text += line
                self._changed.notify()
        with self._changed:
            self._over = True
            self._changed.notify()
