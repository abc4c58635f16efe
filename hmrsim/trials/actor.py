"""One controller in this process, which can be killed."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import suppress
from typing import TYPE_CHECKING, Final

from hmrsim.errors import SimulationStopped
from hmrsim.trials.endings import control
from hmrsim.trials.trial import TOKEN_GONE
from hmrsim_zenoh.client.client import Client

if TYPE_CHECKING:
    from hmrsim.trials.endings import Player
    from hmrsim_zenoh.hosting.loopback_host import LoopbackHost

GRACE: Final = 5.0
"""Wall seconds that a controller in a thread of its own has to end after it was killed."""


class ControllerKilled(BaseException):
    """The controller is killed; not an Exception, so that it does not catch it by accident."""


class Actor:
    """A controller that is run once, with a client of its own.

    Args:
        name: The participant's name.
        waits: Returns whether what it says has to wait, as other controllers come first; None for never.

    Attributes:
        killed: Whether it was killed.
        ended: Its ending and the cause; None while it runs, and if it was killed.
    """

    def __init__(self, host: LoopbackHost, player: Player, name: str, waits: Callable[[], bool] | None = None) -> None:
        self.name = name
        self.killed = False
        self.ended: tuple[str, str] | None = None
        self._host = host
        self._player = player
        self._session = host.open_session(waits)
        self._client = Client(session=self._session, name=name)
        self._thread: threading.Thread | None = None

    def play(self) -> None:
        """Run it to its end; its client stays open unless it is killed."""
        with suppress(ControllerKilled):
            ended = control(self._player, self._client, self._host.simulator)
            self.ended = None if self.killed else ended
        if self.killed:
            self.close()

    def play_aside(self, stays: Callable[[], bool]) -> None:
        """Run it in a thread of its own; from within the simulation. *stays* returns whether its client stays open."""
        self._host.pacing.lockstep.expect(self.name)
        self._thread = threading.Thread(target=self._play_aside, args=(stays,), name=self.name, daemon=True)
        self._thread.start()

    def plays_aside(self, patience: float = 0.0) -> bool:
        """Return whether it runs in a thread of its own, after so many wall seconds or at its end."""
        if self._thread is None:
            return False
        self._thread.join(patience)
        return self._thread.is_alive()

    def kill(self) -> None:
        """Kill it; from within the simulation, when all of an instant has been taken."""
        if self.killed:
            return
        self.killed = True
        self._host.cut(self._session, ControllerKilled(f"the controller {self.name!r} is killed"))
        lockstep = self._host.pacing.lockstep
        if self.name in lockstep.participants:
            lockstep.drop(self.name, TOKEN_GONE)
        lockstep.expect_no_more(self.name)

    def end(self) -> None:
        """Kill one that runs in a thread of its own, while time stands, and wait for its end."""
        if self.plays_aside():
            self._submit(self.kill)
            self._host.cut(self._session, ControllerKilled("the run has ended"))
            self.plays_aside(GRACE)
        self.close()

    def close(self) -> None:
        """Let it leave."""
        with suppress(ControllerKilled):
            self._client.close()
        with suppress(ControllerKilled):
            self._session.close()

    def _play_aside(self, stays: Callable[[], bool]) -> None:
        self.play()
        if not self.killed and not stays():
            self.close()
            self._submit(lambda: self._host.pacing.lockstep.expect_no_more(self.name))

    def _submit(self, act: Callable[[], None]) -> None:
        with suppress(SimulationStopped):
            self._host.pacing.intervene(act)
        self._host.go_on()
