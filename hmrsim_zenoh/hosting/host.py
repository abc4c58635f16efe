"""A world served over Zenoh from this process: the session, the simulation, and the thread that runs it."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from contextlib import ExitStack, suppress
from dataclasses import replace
from functools import partial
from itertools import chain, product
from typing import TYPE_CHECKING, Final, Self

import zenoh

from hmrsim.actions import registry as all_actions
from hmrsim.errors import NoRoute, SimulationStopped
from hmrsim.protocol.goal import WORLD
from hmrsim.protocol.time import TokenSeen
from hmrsim.services import registry as all_services
from hmrsim.settings.run import RunSettings
from hmrsim.simulation.simulator import Simulator
from hmrsim.timing.pacing import Pacing, unwatched
from hmrsim.timing.result_retention import Retention
from hmrsim_zenoh.errors import BadOptions, ParticipantLost, PrefixTaken
from hmrsim_zenoh.hosting.succession import RouterSuccession
from hmrsim_zenoh.server.decode_time import AdvanceRequest, CommandRequest, JoinRequest
from hmrsim_zenoh.server.inbox import ChannelInbox
from hmrsim_zenoh.server.interest import SubscriberWatch
from hmrsim_zenoh.server.server import Server
from hmrsim_zenoh.server.tokens import Claim, LivelinessTokens
from hmrsim_zenoh.server.world_info import Description, Sessions
from hmrsim_zenoh.wire import encoding
from hmrsim_zenoh.wire.enclave import SIMULATOR
from hmrsim_zenoh.wire.envelopes import plain, read
from hmrsim_zenoh.wire.keys import DEFAULT_PREFIX, Keys
from hmrsim_zenoh.wire.options import SessionOptions
from hmrsim_zenoh.wire.session import MAX_MESSAGE, enclave_of, open_server

if TYPE_CHECKING:
    from hmrsim.interfaces.message import Message
    from hmrsim.protocol.sinks import Sink
    from hmrsim.timing.pacing import Watchers
    from hmrsim.world_checks import LoadedWorld
    from hmrsim_zenoh.ros2.server import Ros2Server
    from hmrsim_zenoh.ros2.wires import Wire

_log = logging.getLogger(__name__)

_LAG: Final = "the machine can't keep up: simulated time is %.1f wall seconds behind in all"
_SIMULATORS: Final = 256
"""The number of simulators that may wait to be looked at."""
_STOP_SECONDS = 1.5
"""Wall seconds within which the simulation thread has to end every goal."""


class Host:
    """Serves a world until it is stopped; a context manager that closes everything.

    Args:
        wires: The ROS 2 wires to serve beside the JSON wire.
        sinks: Further sinks of events.
        watchers: Make further sinks from the simulator and its pacing.
        on_wait: Called whenever the simulation thread is about to wait.
        preparations: Optional warm-up, run step by step in lockstep while time stands still.

    Attributes:
        endpoints: The endpoints on which the session listens.
        simulator: Other threads may read it while it runs, but must not change it.
        pacing: The clock that advances its time; read-only, too.
        losses: The loss and duplication of requests and answers; for the simulation's thread once it runs.
        options: The options of the session, with the prefix that is served.
        error: The error that ended the simulation thread; None if it runs or ended regularly.

    Raises:
        PortTaken: Another process listens on the endpoint.
        SimulatorNotFound: No peer answers at an endpoint to connect to.
        BadOptions: The session's options are invalid.
        PrefixTaken: Another simulator serves this prefix.
    """

    pacing: Pacing
    _server: Server
    _description: Description

    def __init__(
        self,
        loaded: LoadedWorld,
        options: SessionOptions = SessionOptions(),  # noqa: B008 - frozen
        settings: RunSettings = RunSettings(),  # noqa: B008 - frozen
        *,
        wires: Sequence[Wire] = (),
        sinks: Sequence[Sink] = (),
        watchers: Watchers = unwatched,
        on_wait: Sequence[Callable[[], None]] = (),
        preparations: Iterable[object] = (),
    ) -> None:
        try:
            keys = Keys(options.prefix, loaded.world.remap)
        except ValueError as error:
            raise BadOptions(f"--prefix: {error}") from None
        self.error: BaseException | None = None
        self._settings = settings
        self._wires = wires
        self._inbox = ChannelInbox()
        self.losses = self._inbox.losses
        self._servers: list[Server | Ros2Server] = []
        self._ros2: list[Ros2Server] = []
        self._reason = "the simulation has ended"
        self._ended = threading.Event()
        enclave = enclave_of(replace(options, default_role=SIMULATOR))
        self._session, self.endpoints = open_server(
            options, join=bool(wires), max_message=max(MAX_MESSAGE, 2 * settings.max_payload)
        )
        retention = Retention(settings.result_timeout, settings.keep_results)

        def serving(simulator: Simulator) -> Sequence[Sink]:
            self._serve(simulator, keys, sessions)
            self.pacing = Pacing(
                simulator,
                self._inbox,
                retention,
                settings,
                on_lag=partial(_log.warning, _LAG),
                on_wait=on_wait,
                preparations=chain(_warm_up(simulator), preparations),
            )
            return [*self._servers, self.pacing.lockstep, *watchers(simulator, self.pacing)]

        try:
            sessions = Sessions(self._session, enclave.access_control) if enclave else None
            self._claim, keys = _claimed(self._session, keys, wires, options.connect)
            self._tokens = LivelinessTokens(self._session, keys)
            self.simulator = Simulator(
                loaded.world,
                settings,
                [retention, *sinks],
                watchers=serving,
                services=all_services(),
                hindrance=lambda: self.pacing.hindrance,
            )
        except BaseException:
            self._session.close()
            self._join()
            raise
        # Called in a separate thread, which may lag behind the requests of participants.
        handler = zenoh.handlers.Callback(self._note_token)
        liveliness = self._session.liveliness()
        self._participants = liveliness.declare_subscriber(keys.participants(), handler, history=True)
        self.options = replace(options, prefix=keys.prefix)
        joined = bool(wires) and not options.connect and bool(self._session.info.routers_zid())
        self._succession = RouterSuccession(self._session, options, self.endpoints) if joined else None
        self._thread = threading.Thread(target=self._run, name="hmrsim-simulation", daemon=True)

    def __enter__(self) -> Self:
        """Return the host; it does not run before `start`."""
        return self

    def __exit__(self, *_error: object) -> None:
        """Stop, and close the session."""
        self.stop()

    def start(self) -> None:
        """Run the simulation in its thread and declare it on the network."""
        self._tokens.declare(self.simulator.robots.keys())
        for ros2 in self._ros2:
            ros2.start()
        self._thread.start()
        self._claim.watch(self._give_way)

    def wait(self, timeout: float | None = None) -> bool:
        """Wait up to *timeout* wall seconds for the end of the simulation; return whether it has ended."""
        return self._ended.wait(timeout)

    def end(self, reason: str) -> None:
        """End the run once all events of this instant are processed; a sink may call it.

        Args:
            reason: The message in the results of the active goals and in the answers to clients.
        """
        self._reason = reason
        self.pacing.finish_instant()

    def stop(self, reason: str = "the simulator was stopped") -> None:
        """End every goal, close the session and return within two seconds; from any thread except the simulation's.

        Args:
            reason: The message in the results of the active goals.
        """
        self._reason = reason
        self._inbox.close()
        if self._thread.is_alive():
            self._thread.join(_STOP_SECONDS)
        self._inbox.leave()
        if self._succession is not None:
            self._succession.close()
        self._session.close()
        self._join()

    def _give_way(self, taken: PrefixTaken) -> None:
        """End the simulation, as another simulator has the prefix."""
        self.error = taken
        self._reason = str(taken)
        self._inbox.close()

    def _run(self) -> None:
        """Run the simulation; whatever ends it, every goal gets its result and the liveliness tokens are undeclared."""
        try:
            self.pacing.run()
        except BaseException as error:  # noqa: BLE001 - kept for the main thread, which ends the process with it
            self.error = error
            self._reason = f"the simulation died of {type(error).__name__}: {error}".partition("\n")[0]
        if self.pacing.loss and self.error is None:
            self.error = ParticipantLost(f"the run has ended, as {self.pacing.loss}")
            self._reason = str(self.error)
        try:
            self._finish()
        except BaseException as error:  # noqa: BLE001 - as above
            self.error = self.error or error
        finally:
            self._claim.undeclare()
        self._ended.set()

    def _finish(self) -> None:
        """End every goal, answer pending requests, and undeclare the simulation."""
        with ExitStack() as afterwards:
            afterwards.callback(self._tokens.undeclare)
            for ros2 in self._ros2:
                afterwards.callback(ros2.close)
            afterwards.callback(self._server.finish, self.pacing.submit, self.simulator.answer)
            self.pacing.end(self._reason)

    def _join(self) -> None:
        """Wait for threads that may still be in a call of the session, after it was closed."""
        for server in self._servers:
            server.join()

    def _serve(self, simulator: Simulator, keys: Keys, sessions: Sessions | None) -> None:
        """Open the servers of the simulation on all wires."""
        settings = self._settings
        self._description = Description(
            simulator, lambda: self.pacing, settings.run_id, sessions, hurries=lambda: self.pacing.hurries
        )
        self._server = Server(
            self._session,
            keys,
            self._description,
            submit=simulator.submit,
            on_roster=self._follow,
            settings=settings,
            inbox=self._inbox,
            interest=SubscriberWatch,
        )
        self._servers.append(self._server)
        if self._wires:
            # Loaded only where ROS 2 wires are served.
            from hmrsim_zenoh.ros2.server import open_servers  # noqa: PLC0415

            self._ros2 = open_servers(
                self._session,
                self._wires,
                simulator,
                self._inbox,
                planner=self._server.planner,
                hurries=self._description.hurries,
                prefix=keys.prefix,
                max_payload=settings.max_payload,
            )
            self._servers.extend(self._ros2)

    def _note_token(self, sample: zenoh.Sample) -> None:
        """Report to the simulation that a participant's liveliness token has come or gone.

        A token that has gone while there is another one belonged to an earlier participation of the same name.
        """
        alive = sample.kind == zenoh.SampleKind.PUT
        with suppress(SimulationStopped, zenoh.ZError):
            if alive or not any(reply.ok for reply in self._session.liveliness().get(sample.key_expr)):
                self._inbox.put(TokenSeen(str(sample.key_expr).rpartition("/")[2], alive=alive))

    def _follow(self) -> None:
        """Serve the current robots; in the simulation's thread."""
        cut_off = self.simulator.dispatcher.cut_off
        self._description.forget()
        self._tokens.follow(self.simulator.robots.keys(), cut_off)
        self._server.follow()
        for ros2 in self._ros2:
            ros2.follow(self.simulator, cut_off)


def _claimed(session: zenoh.Session, keys: Keys, wires: Sequence[Wire], connect: Collection[str]) -> tuple[Claim, Keys]:
    """Return the claim on a prefix, and the keys with it.

    If another simulator has the default prefix, but is in another ROS domain, the prefix gets the number of the domain.

    Raises:
        PrefixTaken: Another simulator has the prefix.
    """
    try:
        return Claim(session, keys, connect), keys
    except PrefixTaken:
        from hmrsim_zenoh.ros2.wires import RmwZenoh  # noqa: PLC0415 - loaded with ROS 2 wires only

        domain = next((wire.domain for wire in wires if isinstance(wire, RmwZenoh)), None)
        others = _domains(session) if keys.prefix == DEFAULT_PREFIX else set()
        if domain is None or not others or str(domain) in others:
            raise
    other = replace(keys, prefix=f"{keys.prefix}_{domain}")
    claim = Claim(session, other, connect)
    _log.warning("another simulator has the prefix %r; using --prefix %s", keys.prefix, other.prefix)
    return claim, other


def _domains(session: zenoh.Session) -> set[str]:
    """Return the ROS domains of other simulators on the network."""
    from hmrsim_zenoh.ros2.keys import domain_of, tokens_of_node  # noqa: PLC0415 - as above
    from hmrsim_zenoh.ros2.names import WORLD_NODE  # noqa: PLC0415 - as above

    replies = session.liveliness().get(tokens_of_node(WORLD_NODE), zenoh.handlers.FifoChannel(_SIMULATORS))
    return {domain_of(str(reply.ok.key_expr)) for reply in replies if reply.ok is not None}


def _warm_up(simulator: Simulator) -> Iterator[None]:
    """Prepare for the actions of a simulation's robots and for routes to the places of its world.

    pydantic builds a message's validator and serializer upon first use, which takes 0.1 s for MoveIt's large messages.
    Yields after each step; a step takes at most 0.1 s.
    """
    for request in (JoinRequest, AdvanceRequest, CommandRequest):
        plain(request)
    yield
    world, servers = simulator.world, simulator.dispatcher.servers
    served = {name for robot in (*simulator.robots, WORLD) for name in servers.actions_of(robot)}
    for name, action in all_actions().items():
        if name in served:
            goal: type[Message] = action.goal
            read(plain(goal), b"{}")
            encoding.message(action.result())
            yield
    speeds = sorted({robot.speed for robot in simulator.robots.values()})
    points = [*(place.at for place in world.places.values()), *(dock.at for dock in world.docks.values())]
    for point, speed in product(points, speeds):
        # A goal to a place without a route is aborted with that reason.
        with suppress(NoRoute):
            simulator.graph.find_ways(world.point(point), speed)
        yield
