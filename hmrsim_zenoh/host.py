"""A world served over Zenoh from this process: the session, the simulator, the servers and the simulation thread."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Iterable, Sequence
from contextlib import ExitStack, suppress
from dataclasses import replace
from itertools import chain
from typing import TYPE_CHECKING, Self

import zenoh

from hmrsim.actions import registry as all_actions
from hmrsim.errors import SimulationStopped
from hmrsim.protocol.time import TokenSeen
from hmrsim.services import registry as all_services
from hmrsim.settings.run import RunSettings
from hmrsim.simulation.simulator import Simulator
from hmrsim.timing.pacing import Pacing
from hmrsim.timing.result_retention import Retention
from hmrsim_zenoh.errors import BadOptions, PrefixTaken
from hmrsim_zenoh.server import warm_up
from hmrsim_zenoh.server.claim import Claim
from hmrsim_zenoh.server.liveliness import LivelinessTokens
from hmrsim_zenoh.server.server import Server
from hmrsim_zenoh.server.sessions import Sessions
from hmrsim_zenoh.server.world_info import Description
from hmrsim_zenoh.wire.enclave import SIMULATOR
from hmrsim_zenoh.wire.keys import Keys
from hmrsim_zenoh.wire.options import SessionOptions
from hmrsim_zenoh.wire.session import MAX_MESSAGE, enclave_of, open_server

if TYPE_CHECKING:
    from hmrsim.protocol.sinks import Sink
    from hmrsim.world_checks import LoadedWorld
    from hmrsim_zenoh.ros2.server import Ros2Server
    from hmrsim_zenoh.ros2.wires import Wire

_log = logging.getLogger(__name__)

_STOP_SECONDS = 1.5
"""Wall seconds within which the simulation thread has to end every goal."""


def _warn_of_lag(lag: float) -> None:
    _log.warning("the machine can't keep up: simulated time is %.1f wall seconds behind in all", lag)


class Host:
    """Serves a world until it is stopped; a context manager that closes everything.

    Args:
        wires: The ROS 2 wires to serve beside the JSON wire.
        sinks: Further sinks of events.
        watchers: Make further sinks from the simulator and its pacing.
        on_wait: Called whenever the simulation thread is about to wait.
        preparations: Optional warm-up, run step by step in lockstep while time stands still.

    Attributes:
        endpoints: What the session listens on.
        simulator: Other threads may read it while it runs, but must not change it.
        pacing: Likewise.
        error: The error that ended the simulation thread; None if it runs or ended regularly.

    Raises:
        PortTaken: Another process listens on the endpoint.
        SimulatorNotFound: No peer answers at an endpoint to connect to.
        BadOptions: The session's options are invalid.
        PrefixTaken: Another simulator serves this prefix.
    """

    pacing: Pacing
    _description: Description
    _server: Server

    def __init__(
        self,
        loaded: LoadedWorld,
        options: SessionOptions = SessionOptions(),  # noqa: B008 - frozen
        settings: RunSettings = RunSettings(),  # noqa: B008 - frozen
        *,
        wires: Sequence[Wire] = (),
        sinks: Sequence[Sink] = (),
        watchers: Callable[[Simulator, Pacing], Sequence[Sink]] = lambda _simulator, _pacing: (),
        on_wait: Sequence[Callable[[], None]] = (),
        preparations: Iterable[object] = (),
    ) -> None:
        try:
            self._keys = Keys(options.prefix, loaded.world.remap)
        except ValueError as error:
            raise BadOptions(f"--prefix: {error}") from None
        self._settings = settings
        self._wires = wires
        self._retention = Retention(settings.result_timeout, settings.keep_results)
        self.error: BaseException | None = None
        self._reason = "the simulation has ended"
        self._ended = threading.Event()
        self._ros2: list[Ros2Server] = []
        self._servers: list[Server | Ros2Server] = []

        def serving(simulator: Simulator) -> Sequence[Sink]:
            self._serve(simulator)
            self.pacing = self._paced(simulator, on_wait, preparations)
            return [*self._servers, self.pacing.lockstep, *watchers(simulator, self.pacing)]

        enclave = enclave_of(replace(options, default_role=SIMULATOR))
        self._session, self.endpoints = open_server(
            options, join=bool(wires), max_message=max(MAX_MESSAGE, 2 * settings.max_payload)
        )
        try:
            self._sessions = Sessions(self._session, enclave.access_control) if enclave else None
            self._claim = Claim(self._session, self._keys)
            self._tokens = LivelinessTokens(self._session, self._keys)
            self.simulator = Simulator(
                loaded.world,
                settings,
                [self._retention, *sinks],
                watchers=serving,
                services=all_services(),
                hindrance=lambda: self.pacing.hindrance,
            )
        except BaseException:
            self._close()
            raise
        self._participants = self._watch_participants()
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

    def stop(self, reason: str = "the simulator was stopped") -> None:
        """End every goal, close the session and return within two seconds; from any thread except the simulation's.

        Args:
            reason: The message in the results of the active goals.
        """
        self._reason = reason
        self._server.close()
        if self._thread.is_alive():
            self._thread.join(_STOP_SECONDS)
        self._server.inbox.leave()
        self._close()

    def _give_way(self, taken: PrefixTaken) -> None:
        """End the simulation, as another simulator has the prefix."""
        self.error = taken
        self._reason = str(taken)
        self._server.close()

    def _close(self) -> None:
        """Close the session and wait for threads that may still be in a Zenoh call."""
        self._session.close()
        for server in self._servers:
            server.join()

    def _run(self) -> None:
        """Run the simulation; whatever ends it, every goal gets its result and the liveliness tokens are undeclared."""
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
            afterwards.callback(self._claim.undeclare)
            afterwards.callback(self._tokens.undeclare)
            for ros2 in self._ros2:
                afterwards.callback(ros2.close)
            afterwards.callback(self._server.finish, self.pacing.submit, self.simulator.answer)
            self.simulator.stop(self._reason)

    def _watch_participants(self) -> zenoh.Subscriber[None]:
        """Report the participants' liveliness tokens to the simulation."""

        def on_token(sample: zenoh.Sample) -> None:
            name = str(sample.key_expr).rpartition("/")[2]
            with suppress(SimulationStopped):
                self._server.inbox.put(TokenSeen(name, alive=sample.kind == zenoh.SampleKind.PUT))

        handler = zenoh.handlers.Callback(on_token)
        return self._session.liveliness().declare_subscriber(self._keys.participants(), handler, history=True)

    def _serve(self, simulator: Simulator) -> None:
        """Open the servers of a simulation on all wires."""
        settings = self._settings
        self._description = Description(
            simulator,
            lambda: self.pacing.state,
            settings.run_id,
            self._sessions,
            hurries=lambda: self.pacing.hurries,
        )
        self._server = Server(
            self._session,
            self._keys,
            self._description,
            actions=all_actions(),
            services=all_services(),
            submit=simulator.submit,
            on_roster=self._follow,
            settings=settings,
        )
        self._servers.append(self._server)
        if self._wires:
            # Loaded only where ROS 2 wires are served.
            from hmrsim_zenoh.ros2.server import open_servers  # noqa: PLC0415

            self._ros2 = open_servers(
                self._session,
                self._wires,
                simulator,
                self._server.inbox,
                planner=self._server.planner,
                hurries=lambda: self._description.hurries,
                prefix=self._keys.prefix,
                max_payload=settings.max_payload,
            )
            self._servers.extend(self._ros2)

    def _paced(
        self, simulator: Simulator, on_wait: Sequence[Callable[[], None]], preparations: Iterable[object]
    ) -> Pacing:
        return Pacing(
            simulator,
            self._server.inbox,
            self._retention,
            self._settings,
            on_lag=_warn_of_lag,
            on_wait=on_wait,
            preparations=chain(warm_up.steps(simulator), preparations),
        )

    def _follow(self) -> None:
        """Serve the current robots; in the simulation thread."""
        cut_off = self.simulator.dispatcher.cut_off
        self._description.forget()
        self._tokens.follow(self.simulator.robots.keys(), cut_off)
        self._server.follow()
        for ros2 in self._ros2:
            ros2.follow(self.simulator, cut_off)
