"""A world served within this process: no network, no thread, and time that moves while a client waits for it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Self

from hmrsim.protocol.time import LOCKSTEP
from hmrsim.settings.run import RunSettings
from hmrsim_zenoh.hosting.local_commands import LocalCommands
from hmrsim_zenoh.hosting.served_simulation import Observers, ServedSimulation, Wiring
from hmrsim_zenoh.loopback.exchange import Exchange
from hmrsim_zenoh.loopback.session import LoopbackSession, open_session
from hmrsim_zenoh.server.local_intake import within
from hmrsim_zenoh.wire.keys import Keys

if TYPE_CHECKING:
    import zenoh

    from hmrsim.protocol.sinks import Sink
    from hmrsim.simulation.simulator import Simulator
    from hmrsim.timing.pacing import Pacing
    from hmrsim.world.model import World
    from hmrsim_zenoh.server.losses import Losses
    from hmrsim_zenoh.server.server import Server


class LoopbackHost:
    """Serves a world to sessions of this process until it is stopped; a context manager that stops it.

    The simulation runs in the thread of whoever sends a request, before the call returns: in lockstep until all
    participants have been granted time, or one of them has yet to ask. What clients see, and the trace, is what it is
    over Zenoh.

    Args:
        settings: The clock is lockstep, whatever they say.
        prefix: The prefix of all keys.
        sinks: Further sinks of events.
        watchers: Make further sinks from the simulator and its pacing.

    Attributes:
        simulator: The simulator; to be read only.
        pacing: What advances its time; likewise.

    Raises:
        ValueError: The prefix is none.
    """

    def __init__(
        self,
        world: World,
        settings: RunSettings = RunSettings(),  # noqa: B008 - frozen
        *,
        prefix: str = "hmrsim",
        sinks: Sequence[Sink] = (),
        watchers: Callable[[Simulator, Pacing], Sequence[Sink]] = lambda _simulator, _pacing: (),
    ) -> None:
        self._reason = "the simulation has ended"
        self._begun = self._ended = False
        self._exchange = Exchange(self._run)
        self._session = open_session(self._exchange)
        self._served = ServedSimulation(
            Wiring(self._session, Keys(prefix, world.remap), within(self._exchange), answers=self._answers),
            world,
            settings.model_copy(update={"clock": LOCKSTEP}),
            Observers(sinks, watchers),
            lockstep_only=True,
        )
        self.simulator = self._served.simulator
        self.pacing = self._served.pacing
        self._begun = True
        self._served.declare()

    def __enter__(self) -> Self:
        """Return the host."""
        return self

    def __exit__(self, *_error: object) -> None:
        """Stop."""
        self.stop()

    @property
    def losses(self) -> Losses:
        """What of requests and answers is lost, or comes twice."""
        return self._served.losses

    def open_session(self, waits: Callable[[], bool] | None = None) -> zenoh.Session:
        """Return a session with the simulation, which the caller closes; it passes for one of Zenoh's.

        *waits* returns whether what the session wants to send has to wait, as another thread comes first.
        """
        return open_session(self._exchange, self._commands.send, waits)

    def cut(self, session: zenoh.Session, error: BaseException) -> None:
        """Cut a session off, as the end of its process would; also from within the simulation.

        Each call of the session raises *error* from now on, also one under way.
        """
        if isinstance(session, LoopbackSession):
            session.cut(error)

    def go_on(self) -> None:
        """Have the simulation run until it can't go on without a message."""
        self._exchange.settle()

    def end(self, reason: str) -> None:
        """End the run after this instant, of which all is taken still; from within the simulation, as a sink may.

        Args:
            reason: The message in the results of the active goals, and what clients are told.
        """
        self._reason = reason
        self.pacing.finish_instant()

    def stop(self, reason: str = "the simulator was stopped") -> None:
        """End every goal.

        Args:
            reason: The message in the results of the active goals.
        """
        self._reason = reason
        self._served.close()
        self._exchange.settle()
        self._served.leave()
        self._session.close()

    def _answers(self, server: Server) -> LocalCommands:
        self._commands = LocalCommands(self._exchange, server)
        return self._commands

    def _run(self, again: bool) -> None:  # noqa: FBT001 - as the exchange calls it
        if again and not self._served.server.inbox.waiting:
            return
        if self._begun and not self._ended and not self.pacing.run_until_idle():
            self._ended = True
            self._served.finish(self._reason)
