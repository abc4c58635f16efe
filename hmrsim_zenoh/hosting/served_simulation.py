"""A simulator with its servers on an open session."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING

import zenoh

from hmrsim.errors import SimulationStopped
from hmrsim.protocol.time import TokenSeen
from hmrsim.services import registry as all_services
from hmrsim.simulation.simulator import Simulator
from hmrsim.timing.pacing import Pacing
from hmrsim.timing.result_retention import Retention
from hmrsim_zenoh.server.inbox import ChannelInbox
from hmrsim_zenoh.server.interest import SubscriberWatch
from hmrsim_zenoh.server.server import Server
from hmrsim_zenoh.server.tokens import LivelinessTokens
from hmrsim_zenoh.server.world_info import Description

if TYPE_CHECKING:
    from hmrsim.protocol.sinks import Sink
    from hmrsim.settings.run import RunSettings
    from hmrsim.world.model import World
    from hmrsim_zenoh.ros2.server import Ros2Server
    from hmrsim_zenoh.ros2.wires import Wire
    from hmrsim_zenoh.server.losses import Losses
    from hmrsim_zenoh.server.world_info import Sessions
    from hmrsim_zenoh.wire.keys import Keys

_log = logging.getLogger(__name__)

Watchers = Callable[[Simulator, Pacing], "Sequence[Sink]"]
"""Makes further sinks of a simulation."""


def unwatched(_simulator: Simulator, _pacing: Pacing) -> Sequence[Sink]:
    """Return no further sinks."""
    return ()


def _warn_of_lag(lag: float) -> None:
    _log.warning("the machine can't keep up: simulated time is %.1f wall seconds behind in all", lag)


@dataclass(frozen=True)
class Wiring:
    """The session, keys and wires on which a simulation is served.

    Attributes:
        session: An open session.
        keys: How keys are spelled there.
        sessions: The connected sessions, if the simulator is secured.
        wires: The ROS 2 wires to serve beside the JSON wire.
    """

    session: zenoh.Session
    keys: Keys
    sessions: Sessions | None = None
    wires: Sequence[Wire] = ()


@dataclass(frozen=True)
class Observers:
    """The observers of a simulation.

    Attributes:
        sinks: Sinks of events.
        watchers: Make further sinks from the simulator and its pacing.
        on_wait: Called whenever the simulation is about to wait.
    """

    sinks: Sequence[Sink] = ()
    watchers: Watchers = unwatched
    on_wait: Sequence[Callable[[], None]] = ()


class ServedSimulation:
    """A simulator, its pacing, and its servers on all wires.

    Args:
        wiring: Where to serve it. The caller closes the session; where this raises an error, it is closed.
        preparations: Return optional work, done step by step in lockstep while time stands still.

    Attributes:
        simulator: The simulator.
        pacing: The clock that advances its time.
        server: The server of the JSON wire.
    """

    pacing: Pacing
    server: Server
    _description: Description

    def __init__(
        self,
        wiring: Wiring,
        world: World,
        settings: RunSettings,
        observers: Observers,
        *,
        preparations: Callable[[Simulator], Iterable[object]] = lambda _simulator: (),
    ) -> None:
        self._wiring = wiring
        self._settings = settings
        self._ros2: list[Ros2Server] = []
        self._servers: list[Server | Ros2Server] = []
        retention = Retention(settings.result_timeout, settings.keep_results)

        def serving(simulator: Simulator) -> Sequence[Sink]:
            self._serve(simulator)
            self.pacing = Pacing(
                simulator,
                self.server.inbox,
                retention,
                settings,
                on_lag=_warn_of_lag,
                on_wait=observers.on_wait,
                preparations=iter(preparations(simulator)),
            )
            return [*self._servers, self.pacing.lockstep, *observers.watchers(simulator, self.pacing)]

        self._tokens = LivelinessTokens(wiring.session, wiring.keys)
        try:
            self.simulator = Simulator(
                world,
                settings,
                [retention, *observers.sinks],
                watchers=serving,
                services=all_services(),
                hindrance=lambda: self.pacing.hindrance,
            )
        except BaseException:
            wiring.session.close()
            self.join()
            raise
        self._participants = self._watch_participants()

    @property
    def losses(self) -> Losses:
        """The loss and duplication of requests and answers."""
        return self.server.inbox.losses

    def declare(self) -> None:
        """Declare it on the session: clients may send goals from now on."""
        self._tokens.declare(self.simulator.robots.keys())
        for ros2 in self._ros2:
            ros2.start()

    def close(self) -> None:
        """Close the inbox, so that the run ends."""
        self.server.close()

    def finish(self, reason: str) -> None:
        """End every goal, answer pending requests, and undeclare the simulation.

        Args:
            reason: The message in the results of the active goals.
        """
        with ExitStack() as afterwards:
            afterwards.callback(self._tokens.undeclare)
            for ros2 in self._ros2:
                afterwards.callback(ros2.close)
            afterwards.callback(self.server.finish, self.pacing.submit, self.simulator.answer)
            self.pacing.end(reason)

    def leave(self) -> None:
        """End the threads that take queries, after `close`."""
        self.server.inbox.leave()

    def join(self) -> None:
        """Wait for threads that may still be in a call of the session, after it was closed."""
        for server in self._servers:
            server.join()

    def _serve(self, simulator: Simulator) -> None:
        """Open the servers of a simulation on all wires."""
        settings = self._settings
        self._description = Description(
            simulator,
            lambda: self.pacing.state,
            settings.run_id,
            self._wiring.sessions,
            hurries=lambda: self.pacing.hurries,
        )
        self.server = Server(
            self._wiring.session,
            self._wiring.keys,
            self._description,
            submit=simulator.submit,
            on_roster=self._follow,
            settings=settings,
            inbox=ChannelInbox,
            interest=SubscriberWatch,
        )
        self._servers.append(self.server)
        if self._wiring.wires:
            # Loaded only where ROS 2 wires are served.
            from hmrsim_zenoh.ros2.server import open_servers  # noqa: PLC0415

            self._ros2 = open_servers(
                self._wiring.session,
                self._wiring.wires,
                simulator,
                self.server.inbox,
                planner=self.server.planner,
                hurries=lambda: self._description.hurries,
                prefix=self._wiring.keys.prefix,
                max_payload=settings.max_payload,
            )
            self._servers.extend(self._ros2)

    def _watch_participants(self) -> zenoh.Subscriber[None]:
        """Report the participants' liveliness tokens to the simulation."""

        def on_token(sample: zenoh.Sample) -> None:
            name = str(sample.key_expr).rpartition("/")[2]
            with suppress(SimulationStopped):
                self.server.inbox.put(TokenSeen(name, alive=sample.kind == zenoh.SampleKind.PUT))

        handler = zenoh.handlers.Callback(on_token)
        key = self._wiring.keys.participants()
        return self._wiring.session.liveliness().declare_subscriber(key, handler, history=True)

    def _follow(self) -> None:
        """Serve the current robots; in the simulation's thread."""
        cut_off = self.simulator.dispatcher.cut_off
        self._description.forget()
        self._tokens.follow(self.simulator.robots.keys(), cut_off)
        self.server.follow()
        for ros2 in self._ros2:
            ros2.follow(self.simulator, cut_off)
