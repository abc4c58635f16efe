"""A world served within this process: no network, no thread, and time that moves while a client waits for it."""

from __future__ import annotations

from collections.abc import Callable, Collection, Hashable, Mapping, Sequence
from typing import TYPE_CHECKING, Self, TypeVar, cast

from hmrsim.errors import SimulationStopped
from hmrsim.protocol.time import LOCKSTEP
from hmrsim.settings.run import RunSettings
from hmrsim_zenoh.hosting.local_commands import LocalCommands
from hmrsim_zenoh.hosting.served_simulation import Observers, ServedSimulation, Watchers, Wiring, unwatched
from hmrsim_zenoh.loopback.exchange import Exchange, Kind
from hmrsim_zenoh.loopback.session import LoopbackSession
from hmrsim_zenoh.server.inbox import QueryInbox, Reader
from hmrsim_zenoh.server.interest import Interest
from hmrsim_zenoh.wire.keys import Keys

if TYPE_CHECKING:
    import zenoh

    from hmrsim.protocol.commands import AnyCommand
    from hmrsim.protocol.sinks import Sink
    from hmrsim.world.model import World
    from hmrsim_zenoh.server.losses import Losses
    from hmrsim_zenoh.server.server import Server


class LoopbackHost:
    """Serves a world to sessions of this process until it is stopped; a context manager that stops it.

    The simulation runs in the thread that sends a request, before the call returns: until all participants of lockstep
    have been granted time, or until a participant has to ask first. Clients and the trace see the same as over Zenoh.

    Args:
        settings: The settings of the run, except that its clock is lockstep.
        prefix: The prefix of all keys.
        sinks: Further sinks of events.
        watchers: Make further sinks from the simulator and its pacing.

    Attributes:
        simulator: The simulator; read-only.
        pacing: The clock that advances its time; read-only.

    Raises:
        ValueError: The prefix is invalid.
    """

    def __init__(
        self,
        world: World,
        settings: RunSettings = RunSettings(),  # noqa: B008 - frozen
        *,
        prefix: str = "hmrsim",
        sinks: Sequence[Sink] = (),
        watchers: Watchers = unwatched,
    ) -> None:
        self._reason = "the simulation has ended"
        self._begun = self._ended = False
        self._exchange = Exchange(self._run, self._has_messages)
        self._session = cast("zenoh.Session", LoopbackSession(self._exchange))
        self._served = ServedSimulation(
            Wiring(
                self._session,
                Keys(prefix, world.remap),
                LocalInbox,
                LocalInterest,
                answers=self._answers,
            ),
            world,
            settings.model_copy(update={"clock": LOCKSTEP}),
            Observers(sinks, watchers),
            lockstep_only=True,
        )
        self.simulator = self._served.simulator
        self.pacing = self._served.pacing
        self._begun = True
        self._served.declare()
        self.go_on()

    def __enter__(self) -> Self:
        """Return the host."""
        return self

    def __exit__(self, *_error: object) -> None:
        """Stop."""
        self.stop()

    @property
    def losses(self) -> Losses:
        """The loss and duplication of requests and answers."""
        return self._served.losses

    def open_session(self, waits: Callable[[], bool] | None = None) -> zenoh.Session:
        """Return a session with the simulation, which the caller closes; it passes for one of Zenoh's.

        *waits* returns whether what the session wants to send has to wait, as another thread comes first.
        """
        return cast("zenoh.Session", LoopbackSession(self._exchange, self._commands.send, waits))

    def cut(self, session: zenoh.Session, error: BaseException) -> None:
        """Cut a session off, as the end of its process would; also from within the simulation.

        Each call of the session raises *error* from now on, also one under way.
        """
        if isinstance(session, LoopbackSession):
            session.cut(error)

    def go_on(self) -> None:
        """Run the simulation until it needs a message to continue."""
        self._exchange.settle(resume=True)

    def end(self, reason: str) -> None:
        """End the run once all events of this instant are processed; a sink may call it.

        Args:
            reason: The message in the results of the active goals and in the answers to clients.
        """
        self._reason = reason
        self.pacing.finish_instant()

    def stop(self, reason: str = "the simulator was stopped") -> None:
        """Stop the simulation and end every goal.

        Args:
            reason: The message in the results of the active goals.
        """
        self._reason = reason
        self._served.close()
        self.go_on()
        self._served.leave()
        self._session.close()

    def _answers(self, server: Server) -> LocalCommands:
        self._commands = LocalCommands(self._exchange, server)
        return self._commands

    def _has_messages(self) -> bool:
        return self._begun and self._served.server.inbox.waiting

    def _run(self) -> None:
        if self._begun and not self._ended and not self.pacing.run_until_idle():
            self._ended = True
            self._served.finish(self._reason)


class LocalInbox(QueryInbox):
    """An inbox without waiting: the sender of a query runs the simulation."""

    def __init__(
        self,
        session: zenoh.Session,
        key_expr: str,
        reader: Reader,
        *,
        wakeup_key: str,
        prepare: Callable[[zenoh.Query | None], None] = lambda _query: None,
    ) -> None:
        super().__init__(session, key_expr, reader, wakeup_key=wakeup_key, prepare=prepare)
        self._queryables = [session.declare_queryable(key_expr, self.put_query)]

    def serve(
        self,
        key_expr: str,
        *,
        decode: Callable[[zenoh.Query], list[AnyCommand]],
        refuse: Callable[[zenoh.Query], None],
        complete: bool = False,  # noqa: ARG002 - there is no network
    ) -> None:
        """Serve a further key expression."""
        reader = Reader(decode, refuse)
        self._queryables.append(self._session.declare_queryable(key_expr, lambda query: self.put_query(query, reader)))

    def put_query(self, query: zenoh.Query, reader: Reader | None = None) -> None:
        """Add a query."""
        reader = reader or self._reader
        if self.closed:
            reader.refuse(query)
        else:
            self._queries.append((reader, query))

    def put(self, command: AnyCommand) -> None:
        """Add a command.

        Raises:
            SimulationStopped: The inbox is closed.
        """
        if self.closed:
            raise SimulationStopped("the simulation has ended")
        self._commands.append(command)

    def poll(self) -> AnyCommand | None:
        """Return the next command; None when there is none now."""
        if self._commands:
            return self._commands.popleft()
        return super().poll() if self._queries else None

    @property
    def waiting(self) -> bool:
        """Return whether a query or a command waits."""
        return bool(self._commands or self._queries)

    def wait(self, timeout: float | None) -> None:  # noqa: ARG002 - as others
        """Prepare for the next query, and return."""
        self._prepare(None)

    def leave(self) -> None:
        """Undeclare the queryables of the inbox."""
        for queryable in self._queryables:
            queryable.undeclare()


K = TypeVar("K", bound="Hashable")


class LocalInterest(Interest[K]):
    """Knows which kinds of keys had subscribers in this process at the last `look`."""

    def __init__(
        self, session: zenoh.Session, patterns: Mapping[K, str], anything: str, changed: Callable[[], None]
    ) -> None:
        super().__init__(session, patterns, anything, changed)
        self._exchange = cast("LoopbackSession", session).exchange
        self._patterns = patterns
        self._version = -1

    def look(self, kinds: Collection[K] | None = None) -> int:  # noqa: ARG002 - all of them are soon looked up
        """Check all kinds; return how often anything has changed."""
        if self._version != self._exchange.version:
            self._version = self._exchange.version
            for kind, pattern in self._patterns.items():
                listened = bool(self._exchange.matching(Kind.SUBSCRIBER, pattern))
                self._changes += listened != self._listened[kind]
                self._listened[kind] = listened
            self.any = any(self._listened.values())
        return self._changes

    def in_key(self, key: str) -> bool:
        """Return whether a key has a subscriber now."""
        return bool(self._exchange.matching(Kind.SUBSCRIBER, key))
