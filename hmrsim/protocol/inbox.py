"""The inbox: a queue of commands from any thread to that of the simulation."""

from __future__ import annotations

import threading
from collections import deque
from typing import TYPE_CHECKING

from hmrsim.errors import SimulationStopped

if TYPE_CHECKING:
    from hmrsim.protocol.commands import AnyCommand


class Inbox:
    """Commands on their way in, in order of arrival; any thread may put.

    Reading is for the simulation's thread. A subclass may bring commands in by another way.

    Attributes:
        closed: Whether the inbox accepts no further commands.
    """

    def __init__(self) -> None:
        self._commands: deque[AnyCommand] = deque()
        self._changed = threading.Condition()
        self.closed = False

    def put(self, command: AnyCommand) -> None:
        """Add a command and wake the simulation.

        Raises:
            SimulationStopped: The inbox is closed.
        """
        with self._changed:
            if self.closed:
                raise SimulationStopped("the simulation has ended")
            self._commands.append(command)
            self._changed.notify()

    @property
    def waiting(self) -> bool:
        """Return whether a command is waiting in the inbox."""
        return bool(self._commands)

    def poll(self) -> AnyCommand | None:
        """Return the next command, or None if the inbox is empty."""
        return self._commands.popleft() if self._commands else None

    def wait(self, timeout: float | None) -> None:
        """Return when there is a command, the inbox was closed, or *timeout* seconds of wall time have passed."""
        with self._changed:
            self._changed.wait_for(lambda: self._commands or self.closed, timeout)

    def close(self) -> None:
        """Close the inbox, and wake the simulation."""
        with self._changed:
            self.closed = True
            self._changed.notify_all()
