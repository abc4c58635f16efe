"""A world simulated within this process: no network, no thread, and time that moves while a client waits for it."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Collection, Hashable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Self, TypeVar, cast

from hmrsim.errors import SimulationStopped
from hmrsim.protocol.outputs import RosterChanged
from hmrsim.protocol.sinks import SelectiveSink
from hmrsim.protocol.time import LOCKSTEP, ReadTime, TokenSeen
from hmrsim.services import registry as all_services
from hmrsim.settings.run import RunSettings
from hmrsim.simulation.simulator import Simulator
from hmrsim.timing.pacing import Pacing, Watchers, unwatched
from hmrsim_zenoh.client.connection import ReadInfo
from hmrsim_zenoh.client.exchange import Delivery, Exchange, Kind
from hmrsim_zenoh.client.local_connection import LocalConnection, for_client
from hmrsim_zenoh.hosting.local_commands import checked, error_of
from hmrsim_zenoh.server.inbox import QueryInbox, Reader
from hmrsim_zenoh.server.interest import Interest
from hmrsim_zenoh.server.losses import unanswered
from hmrsim_zenoh.server.replies import after_the_end, finish
from hmrsim_zenoh.server.server import Server
from hmrsim_zenoh.server.tokens import LivelinessTokens
from hmrsim_zenoh.server.world_info import Description
from hmrsim_zenoh.wire.envelopes import UnreadableError
from hmrsim_zenoh.wire.keys import Keys

if TYPE_CHECKING:
    import zenoh

    from hmrsim.protocol.commands import AnyCommand
    from hmrsim.protocol.sinks import Sink
    from hmrsim.world.model import World
    from hmrsim_zenoh.client.local_connection import Pending
    from hmrsim_zenoh.hosting.local_commands import ClientCommand


class LoopbackHost(SelectiveSink):
    """Simulates a world for sessions of this process until it is stopped; a context manager that stops it.

    The simulation runs in the thread that sends a request, before the call returns: until all participants of lockstep
    have been granted time, or until a participant has to ask first. Clients and the trace see the same as over Zenoh.
    Keys are served from the first use of one. It is a sink of the simulation, to follow its robots.

    Args:
        settings: The settings of the run, except that its clock is lockstep.
        sinks: Further sinks of events.
        watchers: Make further sinks from the simulator and its pacing.

    Attributes:
        simulator: The simulator; read-only.
        pacing: The clock that advances its time; read-only.
        losses: The loss and duplication of requests and answers.
        delivery: Runs the simulation, and delivers its messages while it pauses.
    """

    pacing: Pacing
    _description: Description

    def __init__(
        self,
        world: World,
        settings: RunSettings = RunSettings(),  # noqa: B008 - frozen
        *,
        sinks: Sequence[Sink] = (),
        watchers: Watchers = unwatched,
    ) -> None:
        if settings.clock != LOCKSTEP:
            settings = settings.model_copy(update={"clock": LOCKSTEP})
        self._settings = settings
        self._keys = Keys(aliases=world.remap)
        self._reason = "the simulation has ended"
        self._begun = self._ended = self._stopped = False
        self._inbox = inbox = LocalInbox()
        self.losses = inbox.losses
        self.delivery = Delivery(self._run, inbox)
        self._followers: dict[Callable[[bool], None], None] = {}
        self._announced: defaultdict[str, int] = defaultdict(int)
        self._exchange: Exchange | None = None
        self._session: LocalConnection | None = None
        self._server: Server | None = None
        self._tokens: LivelinessTokens | None = None

        def watching(simulator: Simulator) -> Sequence[Sink]:
            # Results are kept by number alone: what a run does must not depend on how long it takes.
            self.pacing = Pacing(simulator, inbox, None, settings, lockstep_only=True)
            self._description = Description(simulator, lambda: self.pacing, settings.run_id)
            return [self, self.pacing.lockstep, *watchers(simulator, self.pacing)]

        self.simulator = Simulator(
            world,
            settings,
            sinks,
            watchers=watching,
            services=all_services(),
            hindrance=lambda: self.pacing.hindrance,
        )
        self._begun = True
        self.go_on()

    def __enter__(self) -> Self:
        """Return the host."""
        return self

    def __exit__(self, *_error: object) -> None:
        """Stop."""
        self.stop()

    @property
    def exchange(self) -> Exchange:
        """The declarations of all sessions; the first use begins to serve keys."""
        if self._exchange is None:
            # Not while another thread runs the simulation, to which a sink is added.
            with self.delivery.lock:
                if self._exchange is None:
                    self._exchange = Exchange(self.delivery)
                    if not self._stopped:
                        self._serve_keys()
        return self._exchange

    def open_session(self, waits: Callable[[], bool] | None = None) -> zenoh.Session:
        """Return a session with the simulation, which the caller closes; it passes for one of Zenoh's.

        *waits* returns whether what the session wants to send has to wait, as another thread comes first.
        """
        return cast("zenoh.Session", LocalConnection(self, waits))

    def cut(self, session: zenoh.Session, error: BaseException) -> None:
        """Cut a session off, as the end of its process would; also from within the simulation.

        Each call of the session raises *error* from now on, also one under way.
        """
        if isinstance(session, LocalConnection):
            session.cut(error)

    def send(self, command: ClientCommand | ReadInfo, pending: Pending) -> None:
        """Send a command; *pending* takes its answer, once, while the simulation does not run.

        It is None if the answer is lost, and a `RequestError` if the command can't be served.
        """
        losses, delivery, inbox = self.losses, self.delivery, self._inbox
        if isinstance(command, ReadInfo):
            known = self._refusal(command) if inbox.closed else self._description.info_values()
            delivery.deliver(pending.take, known)
            delivery.settle()
            return
        # Requests that change nothing are exempt, as a client simply repeats them.
        disturbed = losses.active and not isinstance(command, ReadTime)
        pending.may_be_lost = disturbed and losses.watching
        try:
            command = checked(command, pending, self._keys)
            if self._server is None and self._description.plans_externally:
                self.exchange  # noqa: B018 - it begins to serve keys
            if self._server is not None:
                for each in self._server.before(command):
                    inbox.put(each)
            inbox.put(command)
            if disturbed and losses.comes_twice():
                inbox.put(unanswered(command))
        except UnreadableError as error:
            delivery.deliver(pending.take, error_of(error))
        except SimulationStopped:
            # Another thread may have ended the run just now.
            delivery.deliver(pending.take, self._refusal(command))
        delivery.settle(resume=True)

    def loses_answer(self) -> bool:
        """Return whether the current answer is lost, and count it."""
        return self.losses.lost()

    def handler_for(self, kind: type) -> Callable[[Any], object] | None:
        """Return the function that processes outputs of a type; None to ignore them."""
        return self._follow_roster if kind is RosterChanged else None

    def announce(self, name: str, *, alive: bool) -> None:
        """Report that a participant has come or gone; of several with one name, the first comes and the last goes."""
        self._announced[name] += 1 if alive else -1
        if self._announced[name] == alive:
            with suppress(SimulationStopped):
                self._inbox.put(TokenSeen(name, alive=alive))

    def follow(self, on_change: Callable[[bool], None]) -> Callable[[], None]:
        """Report whether the simulation serves its clients, now and when it ends; return a function to stop that."""
        self._followers[on_change] = None
        on_change(not self._ended)
        return lambda: self._followers.pop(on_change, None)

    def go_on(self) -> None:
        """Run the simulation until it needs a message to continue."""
        self.delivery.settle(resume=True)

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
        self._inbox.close()
        self.go_on()
        self._stopped = True
        if self._session is not None:
            self._inbox.leave()
            self._session.close()

    def _run(self) -> None:
        if self._begun and not self._ended and not self.pacing.run_until_idle():
            self._ended = True
            self._finish()

    def _finish(self) -> None:
        """End every goal, answer pending requests, and report the end to the clients."""
        try:
            self.pacing.end(self._reason)
        finally:
            if self._server is None:
                finish(self._inbox, self.pacing.submit, self.simulator.answer)
            else:
                self._server.finish(self.pacing.submit, self.simulator.answer)
            if self._tokens is not None:
                self._tokens.undeclare()
            for on_change in list(self._followers):
                self.delivery.deliver(on_change, False)

    def _refusal(self, command: ClientCommand | ReadInfo) -> Any:
        """Return the answer to a command after the end of the run; None once the host has stopped."""
        return None if self._stopped else for_client(after_the_end(command))

    def _follow_roster(self, _changed: RosterChanged) -> None:
        self._description.forget()
        self._keys = replace(self._keys, aliases=self._description.aliases)

    def _serve_keys(self) -> None:
        """Serve the keys of the simulation, like a simulator on a network."""

        def follow_roster() -> None:
            tokens.follow(self.simulator.robots.keys(), self.simulator.dispatcher.cut_off)
            server.follow()

        session = self._session = LocalConnection(self)
        opened = cast("zenoh.Session", session)
        tokens = self._tokens = LivelinessTokens(opened, self._keys)
        server = self._server = Server(
            opened,
            self._keys,
            self._description,
            submit=self.simulator.submit,
            on_roster=follow_roster,
            settings=self._settings,
            inbox=self._inbox,
            interest=LocalInterest,
        )
        if not self._ended:
            self.simulator.attach(server)
            tokens.declare(self.simulator.robots.keys())


class LocalInbox(QueryInbox):
    """An inbox without waiting: the sender of a command or query runs the simulation."""

    def __init__(self) -> None:
        super().__init__()
        self._queryables: list[zenoh.Queryable[None]] = []

    def open(self, session: zenoh.Session, key_expr: str, reader: Reader, *, wakeup_key: str) -> None:  # noqa: ARG002 - no thread sleeps
        """Take the queries on a key expression from now on."""
        self._reader = reader
        self._queryables.append(session.declare_queryable(key_expr, self.put_query))

    def put_query(self, query: zenoh.Query) -> None:
        """Add a query."""
        if self.closed:
            self._reader.refuse(query)
        else:
            self._queries.append((self._reader, query))

    def put(self, command: AnyCommand) -> None:
        """Add a command.

        Raises:
            SimulationStopped: The inbox is closed.
        """
        if self.closed:
            raise SimulationStopped("the simulation has ended")
        self._commands.append(command)

    def close(self) -> None:
        """Close the inbox, for which no thread waits."""
        self.closed = True

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
        if self._preparation is not None:
            self._prepare(None)

    def leave(self) -> None:
        """Undeclare the queryables of the inbox."""
        for queryable in self._queryables:
            queryable.undeclare()


K = TypeVar("K", bound="Hashable")


class LocalInterest(Interest[K]):
    """Knows which kinds of keys had subscribers in this process at the last `look`."""

    def __init__(self, session: zenoh.Session, patterns: Mapping[K, str], *_: object) -> None:
        super().__init__(patterns)
        self._exchange = cast("LocalConnection", session).simulation.exchange
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
