"""A world served over Zenoh from this process: session, simulator, server and the simulation's thread together."""

from __future__ import annotations

import logging
import math
import threading
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Self

import zenoh

from hmrsim.actions import registry as all_actions
from hmrsim.errors import SimulationStopped
from hmrsim.protocol.time import REALTIME, TokenSeen
from hmrsim.services import registry as all_services
from hmrsim.simulation.simulator import Simulator
from hmrsim.timing.pacing import Pacing
from hmrsim.timing.result_retention import Retention
from hmrsim_zenoh.errors import BadOptions, PrefixTaken
from hmrsim_zenoh.server import warm_up
from hmrsim_zenoh.server.external_planner import Planner
from hmrsim_zenoh.server.liveliness import MAX_TOKENS, Tokens
from hmrsim_zenoh.server.server import Server
from hmrsim_zenoh.server.world_info import Description
from hmrsim_zenoh.wire.envelopes import MAX_PAYLOAD
from hmrsim_zenoh.wire.keys import Keys
from hmrsim_zenoh.wire.session import SessionOptions, open_server

if TYPE_CHECKING:
    from hmrsim.protocol.gateway import Sink
    from hmrsim.world_checks import LoadedWorld
    from hmrsim_zenoh.ros2.server import Ros2Server
    from hmrsim_zenoh.ros2.wires import Wire

_log = logging.getLogger(__name__)

_STOP_SECONDS = 1.5
"""Wall seconds that the simulation's thread is given to end every goal."""


@dataclass(frozen=True)
class HostSettings:
    """How a world is served.

    Attributes:
        clock: How time moves: ``realtime`` or ``lockstep``.
        real_time_factor: Simulated seconds a wall second in real time; 0 for as fast as possible.
        participants: How many have to join before time moves in lockstep, or their names.
        participant_timeout: Wall seconds that one of them may take from a grant to the next request.
        end_on_loss: Whether the run ends when one of them is lost.
        planner_timeout: Wall seconds that a planner outside may take for a path.
        step_size: Simulated seconds of one step.
        duration: Simulated seconds after which to end.
        seed: Replaces the world's.
        feedback_rate: Samples of feedback a second of simulated time.
        odom_rate: Likewise of odometry.
        clock_rate: Likewise of the clock.
        battery_rate: Likewise of batteries, which are told when they reach a level, too.
        detection_rate: Likewise of what sensors see, which is sent when it has changed.
        result_timeout: Wall seconds that a result is kept; negative for ever.
        keep_results: Most ended goals that a robot remembers.
        max_payload: Bytes that a request may have.
        wires: The wires of ROS 2 that are spoken, beside the JSON wire.
    """

    clock: str = REALTIME
    real_time_factor: float = 1.0
    participants: int | tuple[str, ...] = 1
    participant_timeout: float = 30.0
    end_on_loss: bool = False
    planner_timeout: float = 5.0
    step_size: float = 0.1
    duration: float = math.inf
    seed: int | None = None
    feedback_rate: float = 10.0
    odom_rate: float = 10.0
    clock_rate: float = 10.0
    battery_rate: float = 1.0
    detection_rate: float = 10.0
    result_timeout: float = 900.0
    keep_results: int = 1000
    max_payload: int = MAX_PAYLOAD
    wires: tuple[Wire, ...] = ()


def _warn_of_lag(lag: float) -> None:
    _log.warning("the machine can't keep up: simulated time is %.1f wall seconds behind in all", lag)


class Host:
    """Serves a world until it is stopped; a context manager that closes everything.

    Args:
        loaded: The world.
        options: How to open the session.
        settings: How to serve.

    Attributes:
        endpoints: What the session listens on.
        simulator: Other threads may look at it while it runs, but must not touch it.
        pacing: Likewise.
        error: What the simulation's thread died of; None if it lives or ended well.

    Raises:
        PortTaken: Somebody else listens on the endpoint.
        NobodyThere: Nobody answers at an endpoint to connect to.
        BadOptions: The session's options make no sense.
        PrefixTaken: Another simulator serves this prefix.
    """

    def __init__(
        self,
        loaded: LoadedWorld,
        options: SessionOptions = SessionOptions(),  # noqa: B008 - frozen
        settings: HostSettings = HostSettings(),
    ) -> None:
        self._settings = settings
        try:
            self._keys = Keys(options.prefix, loaded.world.remap)
        except ValueError as error:
            raise BadOptions(f"--prefix: {error}") from None
        self._retention = Retention(settings.result_timeout)
        self.simulator = Simulator(
            loaded.world,
            [self._retention],
            seed=settings.seed,
            feedback_rate=settings.feedback_rate,
            odom_rate=settings.odom_rate,
            clock_rate=settings.clock_rate,
            battery_rate=settings.battery_rate,
            detection_rate=settings.detection_rate,
            keep_results=settings.keep_results,
            step_size=settings.step_size,
        )
        self.error: BaseException | None = None
        self._reason = "the simulation has ended"
        self._ended = threading.Event()
        self._servers: list[Server | Ros2Server] = []
        self._session, self.endpoints = open_server(options, join=bool(settings.wires))
        try:
            self._refuse_second()
            self._description = Description(self.simulator, lambda: self.pacing.state)
            self._tokens = Tokens(self._session, self._keys)
            self._server = self._serve()
            self._servers.append(self._server)
            self._ros2 = self._serve_ros2()
            self._servers.extend(self._ros2)
        except BaseException:
            self._close()
            raise
        self.simulator.attach(self._server)
        for ros2 in self._ros2:
            self.simulator.attach(ros2)
        self.pacing = Pacing(
            self.simulator,
            self._server.inbox,
            self._retention,
            clock=settings.clock,
            real_time_factor=settings.real_time_factor,
            duration=settings.duration,
            participants=settings.participants,
            participant_timeout=settings.participant_timeout,
            end_on_loss=settings.end_on_loss,
            on_lag=_warn_of_lag,
            preparations=warm_up.of(self.simulator),
        )
        self._server.submit = self.pacing.submit
        self._server.planner = Planner(
            self._session,
            self._keys,
            self._server.inbox.put,
            timeout=settings.planner_timeout,
            max_payload=settings.max_payload,
        )
        self._server.on_roster = self._follow
        for ros2 in self._ros2:
            ros2.submit, ros2.planner = self.pacing.submit, self._server.planner
        self._participants = self._watch_participants()
        self._thread = threading.Thread(target=self._run, name="hmrsim-simulation", daemon=True)

    def __enter__(self) -> Self:
        """Return the host; it does not run before `start`."""
        return self

    def __exit__(self, *_error: object) -> None:
        """Stop, and close the session."""
        self.stop()

    def attach(self, sink: Sink) -> None:
        """Send events to one more sink; before `start` only."""
        self.simulator.attach(sink)

    def start(self) -> None:
        """Run the simulation in its thread, and tell the network that it is there."""
        self._tokens.declare(self.simulator.robots.keys())
        for ros2 in self._ros2:
            ros2.start()
        self._thread.start()

    def wait(self, timeout: float | None = None) -> bool:
        """Return whether the simulation has ended, after waiting for that up to *timeout* wall seconds."""
        return self._ended.wait(timeout)

    def stop(self, reason: str = "the simulator was stopped") -> None:
        """End every goal, close the session and return within two seconds; from any thread but the simulation's.

        Args:
            reason: What the results of the goals that run then say.
        """
        self._reason = reason
        self._server.close()
        if self._thread.is_alive():
            self._thread.join(_STOP_SECONDS)
        self._server.inbox.leave()
        self._close()

    def _close(self) -> None:
        """Close the session, and wait for whoever may still be in a call of Zenoh's."""
        self._session.close()
        for server in self._servers:
            server.join()

    def _run(self) -> None:
        """Run the simulation; whatever ends it, every goal gets its verdict, and the network learns of the end."""
        try:
            self.pacing.run()
        except BaseException as error:  # noqa: BLE001 - kept for the main thread, which ends the process with it
            self.error = error
            self._reason = f"the simulation died of {type(error).__name__}: {error}".partition("\n")[0]
        try:
            self._finish()
        except BaseException as error:  # noqa: BLE001 - likewise
            self.error = self.error or error
        self._ended.set()

    def _finish(self) -> None:
        with ExitStack() as afterwards:
            afterwards.callback(self._tokens.undeclare)
            for ros2 in self._ros2:
                afterwards.callback(ros2.close)
            afterwards.callback(self._server.finish, self.pacing.submit, self.simulator.answer)
            self.simulator.stop(self._reason)

    def _refuse_second(self) -> None:
        token = self._keys.alive()
        replies = self._session.liveliness().get(token, zenoh.handlers.FifoChannel(16), timeout=1.0)
        if any(reply.ok for reply in replies):
            raise PrefixTaken(f"a simulator serves prefix {self._keys.prefix!r} already; name another with --prefix")

    def _watch_participants(self) -> zenoh.Subscriber[None]:
        """Tell the simulation whose liveliness token comes and goes."""

        def on_token(sample: zenoh.Sample) -> None:
            name = str(sample.key_expr).rpartition("/")[2]
            with suppress(SimulationStopped):
                self._server.inbox.put(TokenSeen(name, alive=sample.kind == zenoh.SampleKind.PUT))

        handler = zenoh.handlers.Callback(on_token)
        return self._session.liveliness().declare_subscriber(self._keys.participants(), handler, history=True)

    def _serve(self) -> Server:
        return Server(
            self._session,
            self._keys,
            actions=all_actions(),
            serves=self._description.serves,
            fixed=self._description.latched,
            services=all_services(),
            declare=len(self.simulator.robots) <= MAX_TOKENS,
            max_payload=self._settings.max_payload,
        )

    def _serve_ros2(self) -> list[Ros2Server]:
        if not self._settings.wires:
            return []
        # Nobody else needs to load it.
        from hmrsim_zenoh.ros2.server import open_servers  # noqa: PLC0415

        return open_servers(
            self._session,
            self._settings.wires,
            self.simulator,
            self._server.inbox,
            prefix=self._keys.prefix,
            max_payload=self._settings.max_payload,
        )

    def _follow(self) -> None:
        """Serve those who are there now; in the simulation's thread."""
        description, cut_off = self._description, self.simulator.dispatcher.cut_off
        description.forget()
        self._tokens.follow(self.simulator.robots.keys(), cut_off)
        self._server.follow(description.serves, description.aliases)
        for ros2 in self._ros2:
            ros2.follow(self.simulator, cut_off)
