"""A trial within this process, whose controller is a tree or a function."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, Final

from hmrsim.errors import SimulationStopped
from hmrsim.program.memory import collect_runs_young
from hmrsim.timing.pacing import Watchers, unwatched
from hmrsim.trials.trial import CRASHED, FAILED, GONE, HUNG, SUCCEEDED, TOKEN_GONE, Ended, TimeLimit, Trial, control
from hmrsim_zenoh.client.client import Client
from hmrsim_zenoh.hosting.loopback_host import LoopbackHost

if TYPE_CHECKING:
    from hmrsim.protocol.sinks import Sink
    from hmrsim.settings.run import RunSettings
    from hmrsim.trials.disturbances import Disturber
    from hmrsim.trials.trial import Player
    from hmrsim.world.model import World

_POLL: Final = 0.002
"""Wall seconds between two checks of controllers in other threads."""


class LocalTrial(Trial):
    """A trial without a network, in which time moves while its clients wait.

    Args:
        player: The controller that `play` runs, if any.
        name: The participant's name of the controller; the ids of goals depend on it.
    """

    def __init__(
        self,
        world: World,
        settings: RunSettings,
        player: Player | None = None,
        *,
        name: str = "client",
        sinks: Sequence[Sink] = (),
        watchers: Watchers = unwatched,
        disturber: Disturber | None = None,
    ) -> None:
        collect_runs_young()
        self._host = LoopbackHost(world, settings, sinks=sinks, watchers=watchers)
        self._player = player
        self._name = name
        self._first: Actor | None = None
        self._others: list[Actor] = []
        self._clients: list[Client] = []
        self._closed = self._over = False
        super().__init__(self._host, disturber)

    @property
    def over(self) -> bool:
        """True if the run ended, by its limit or by a sink, before the trial was closed."""
        return self._over if self._closed else self._host.pacing.over

    def open_client(self, name: str) -> Client:
        """Return a further client, which joins under its own name when it first waits; the trial closes it.

        Time moves only while all participants wait, so each client needs its own thread.
        """
        client = Client(session=self._host.open_session(), name=name)
        self._clients.append(client)
        return client

    def play(self) -> Ended:
        """Run the controller to its end; its clients stay open until the trial is closed."""
        try:
            first = self._begin()
            first.play()
            while first.killed and self._awaits_restart():
                first = self._begin()
                first.play()
            return self._ending(first)
        except TimeLimit as limit:
            return Ended(HUNG, str(limit))

    def close(self) -> None:
        """End all clients, and goals."""
        if self._closed:
            return
        for each in self._others:
            each.end()
        if self._first is not None:
            self._first.close()
        self._close_clients()
        self._over, self._closed = self._host.pacing.over, True
        self._host.stop()

    def _close_clients(self) -> None:
        """Close all clients, the last one first, even if Ctrl-C interrupts one of them."""
        try:
            while self._clients:
                self._clients.pop().close()
        finally:
            if self._clients:
                self._close_clients()

    def _begin(self) -> Actor:
        if self._player is None:
            raise AssertionError
        self._first = Actor(self._host, self._player, self._name)
        return self._first

    @property
    def _own_names(self) -> Sequence[str]:
        return (self._name,)

    def _kill(self, restart_after: float | None) -> None:
        if self._first is None or self._first.killed:
            return
        self._first.kill()
        if restart_after is None:
            self._gone = True
            self._lockstep.expect("", math.inf)
        else:
            self._lockstep.expect(self._name, self.simulator.now + restart_after, self._restarts.set)

    def _add(self) -> None:
        """Start one more controller beside the first; its requests wait for those of the controllers before it."""
        if self._player is None:
            raise AssertionError
        before = (self._name, *(each.name for each in self._others))
        lockstep = self._lockstep
        # The run ends with the first one, which may leave lockstep before.
        lockstep.keep(self._name)
        name = f"{self._name}_{len(before) + 1}"
        actor = Actor(self._host, self._player, name, lambda: not {*before}.isdisjoint(lockstep.waiting_for))
        self._others.append(actor)
        actor.play_aside(stays=lambda: self._gone)

    def _awaits_restart(self) -> bool:
        """Advance time until the killed controller has to be restarted; return False if the run ends before."""
        while not self._restarts.is_set():
            self._host.go_on()
            plays = any(each.plays_aside(_POLL) for each in self._others)
            if self._host.pacing.over:
                # The other controllers learn that the run ended, and end as well.
                for each in self._others:
                    each.plays_aside(GRACE)
                return False
            if not (plays or self._restarts.is_set()):
                return False
        self._restarts.clear()
        return not self._host.pacing.over

    def _ending(self, first: Actor) -> Ended:
        """Return how the run has ended."""
        others = [each.ended for each in self._others if each.ended is not None]
        own = first.ended
        if own is None:
            return Ended(*(others[0] if others else GONE))
        crash = next((cause for ending, cause in others if ending == CRASHED), None)
        if crash is None or own[0] not in {SUCCEEDED, FAILED}:
            return Ended(*own)
        return Ended(CRASHED, f"a second controller: {crash}")


GRACE: Final = 5.0
"""Wall seconds in which a killed controller in another thread has to end."""


class ControllerKilled(BaseException):
    """The controller is killed; not an Exception, so that the controller does not catch it by accident."""


class Actor:
    """One run of a controller, with its own client.

    Args:
        waits: Returns whether its requests wait for those of other controllers; None for never.

    Attributes:
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
        """Run it in a new thread, from within the simulation; *stays* returns whether its client stays open."""
        self._host.pacing.lockstep.expect(self.name)
        self._thread = threading.Thread(target=self._play_aside, args=(stays,), name=self.name, daemon=True)
        self._thread.start()

    def plays_aside(self, patience: float = 0.0) -> bool:
        """Return whether it still runs in another thread, after waiting at most *patience* wall seconds."""
        if self._thread is None:
            return False
        self._thread.join(patience)
        return self._thread.is_alive()

    def kill(self) -> None:
        """Kill it, from within the simulation at the end of an instant."""
        if self.killed:
            return
        self.killed = True
        self._host.cut(self._session, ControllerKilled(f"the controller {self.name!r} is killed"))
        lockstep = self._host.pacing.lockstep
        if self.name in lockstep.participants:
            lockstep.drop(self.name, TOKEN_GONE)
        lockstep.expect_no_more(self.name)

    def end(self) -> None:
        """Kill it if it runs in another thread, and wait for its end."""
        if self.plays_aside():
            self._submit(self.kill)
            self._host.cut(self._session, ControllerKilled("the run has ended"))
            self.plays_aside(GRACE)
        self.close()

    def close(self) -> None:
        """Close its client, which leaves the simulation."""
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
