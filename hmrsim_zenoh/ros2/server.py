"""The server of a ROS 2 wire, which turns queries into commands, and outputs into replies and publications.

It is a sink beside the server of the JSON wire, and feeds the same inbox. Everything except the callbacks of `Peers`
runs in the simulation thread.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Collection, Iterable
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from hmrsim.actions import registry as all_actions
from hmrsim.errors import SimulationStopped
from hmrsim.interfaces.rcl_interfaces import Log
from hmrsim.protocol.commands import CallService, CancelGoal, InterestChanged, SendGoal
from hmrsim.protocol.goal import WORLD, GoalResponse
from hmrsim.protocol.outputs import Answered
from hmrsim.protocol.sinks import SelectiveSink
from hmrsim.services import registry as all_services
from hmrsim_zenoh.errors import BadOptions
from hmrsim_zenoh.ros2.names import names_of
from hmrsim_zenoh.ros2.peers import Peers
from hmrsim_zenoh.ros2.publishing.publications import EMITTED, Publications
from hmrsim_zenoh.ros2.rejection_log import RejectionLog
from hmrsim_zenoh.ros2.requests.catalog import Catalog
from hmrsim_zenoh.ros2.requests.handlers import GetResultHandler, PendingRosReply, SendGoalHandler
from hmrsim_zenoh.ros2.requests.requests import PendingResults, Requests
from hmrsim_zenoh.ros2.requests.subscriptions import FromTopic, Subscriptions
from hmrsim_zenoh.ros2.wires import RmwZenoh, Ros2Dds
from hmrsim_zenoh.server.inbox import Reader
from hmrsim_zenoh.server.publisher import Publisher

if TYPE_CHECKING:
    import zenoh

    from hmrsim.protocol.commands import AnyCommand
    from hmrsim.protocol.topics import Topic
    from hmrsim.simulation.simulator import Simulator
    from hmrsim_zenoh.ros2.requests.handlers import ActionHandler
    from hmrsim_zenoh.ros2.wires import Wire
    from hmrsim_zenoh.server.external_planner import Planner
    from hmrsim_zenoh.server.inbox import ChannelInbox

_log = logging.getLogger(__name__)


def open_servers(
    session: zenoh.Session,
    wires: Iterable[Wire],
    simulator: Simulator,
    inbox: ChannelInbox,
    *,
    planner: Planner,
    hurries: Callable[[], bool],
    prefix: str,
    max_payload: int,
) -> list[Ros2Server]:
    """Return the servers of a simulation, one for each wire.

    Raises:
        BadOptions: The prefix of the JSON wire collides with the keys of a domain or of a robot.
    """
    begin = prefix.partition("/")[0]
    for wire in wires:
        if isinstance(wire, RmwZenoh) and begin == str(wire.domain):
            raise BadOptions(f"--prefix {prefix!r} collides with the keys of ROS domain {wire.domain}; use another")
        if isinstance(wire, Ros2Dds) and begin in simulator.robots:
            raise BadOptions(f"--prefix {prefix!r} collides with the keys of robot {begin!r}; use another")
    options: Any = {"inbox": inbox, "planner": planner, "hurries": hurries, "max_payload": max_payload}
    return [Ros2Server(session, wire, simulator, **options) for wire in wires]


class Ros2Server(SelectiveSink):
    """Serves one simulation on one wire of ROS 2.

    Args:
        session: An open session, which the caller closes.
        wire: How keys are spelled, and the distributions whose types are served.
        simulator: The simulation.
        inbox: Receives the commands of clients.
        planner: The external planner, which may have to be found before a goal.
        hurries: Returns whether time may pass faster than the wall's.
        max_payload: The largest request in bytes.
    """

    def __init__(
        self,
        session: zenoh.Session,
        wire: Wire,
        simulator: Simulator,
        *,
        inbox: ChannelInbox,
        planner: Planner,
        hurries: Callable[[], bool],
        max_payload: int,
    ) -> None:
        actions, services = all_actions(), all_services()
        self._submit = simulator.submit
        self._planner = planner
        self._wire = wire
        self._inbox = inbox
        self._hurries = hurries
        self._changes_reported = 0
        self._looked = -1
        self._looked_for_feedback: dict[str, int] = {}
        names = names_of(simulator)
        self._catalog = Catalog(names, wire.distros, actions=actions, services=services, simulator=simulator)
        self._waiting = PendingResults()
        rejections = RejectionLog()
        self._publications = Publications(
            session,
            wire,
            names,
            actions=actions,
            services=services,
            simulator=simulator,
            changed=self._interest_changed,
        )
        self._peers: Peers | None = None
        if isinstance(wire, RmwZenoh):
            self._peers = Peers(
                session,
                wire.domain,
                served=self._publications.served,
                rejections=rejections,
                came=self._publications.ask,
                gone=self._gone,
            )
            # Referenced, as Zenoh undeclares what is not.
            self._subscriptions = Subscriptions(
                session,
                wire,
                serves=lambda name: bool(self._publications.served(name)),
                put=inbox.put,
                log=lambda topic, text: rejections.warn(f"ROS 2: {topic}: {text}"),
                max_payload=max_payload,
            )
        self._requests = Requests(
            wire,
            self._catalog,
            Publisher(session, declares=True),
            waiting=self._waiting,
            rejections=rejections,
            peers=self._peers,
            reject=lambda node, text: self._publications.log(node, Log.WARN, text),
            max_payload=max_payload,
        )
        for key_expr in wire.request_keys:
            inbox.serve(key_expr, Reader(self._decode, self._refuse), complete=wire.has_types)

    def start(self) -> None:
        """Declare all served parts, in the background."""
        spelled = f"domain {self._wire.domain}" if isinstance(self._wire, RmwZenoh) else "as zenoh-bridge-ros2dds"
        _log.info("ROS 2: %s, %s", spelled, ", ".join(self._wire.distros))
        self._publications.start()

    def follow(self, simulator: Simulator, lost: Collection[str]) -> None:
        """Serve the current robots, except for the *lost* ones."""
        names = names_of(simulator)
        if self._publications.follow(names, lost):
            self._catalog.follow(names)
            self._requests.follow(names.serves)
            if self._peers is not None:
                self._peers.look(self._publications.is_new)

    def wants(self, topic: Topic) -> bool:
        """Return whether a topic has a subscriber."""
        return self._publications.wants(topic)

    def handler_for(self, kind: type) -> Callable[[Any], object] | None:
        """Return the function that replies to queries, or publishes; None for outputs that ROS does not have."""
        if kind is Answered:
            return self._emit_answer
        return self._publications.emit if kind in EMITTED else None

    def _emit_answer(self, output: Answered) -> None:
        asked = output.reply_to
        if isinstance(asked, PendingRosReply) and asked.wire is self._wire:
            self._answer(asked, output.answer)
        elif isinstance(asked, FromTopic) and self._peers is not None:
            asked.answer(output.answer)

    def close(self) -> None:
        """Stop declaring, before the session is closed; later requests are refused."""
        self._publications.close()
        if self._peers is not None:
            self._peers.close()

    def join(self) -> None:
        """Wait for all threads to end, after the session was closed."""
        self._publications.join()

    def _answer(self, pending: PendingRosReply, answer: object) -> None:
        if isinstance(pending.handler, GetResultHandler):
            self._waiting.answered(pending)
        if isinstance(answer, GoalResponse) and not answer.accepted:
            self._requests.log_rejection(pending.client, pending.handler.name, f"rejected: {answer.error_msg}")
        pending.answer(answer)
        if isinstance(pending.handler, SendGoalHandler):
            # A client that subscribes and then sends a goal must get all of its feedback. Status is published anyway.
            self._look_for_feedback(pending.handler)

    def _decode(self, query: zenoh.Query) -> list[AnyCommand]:
        commands = self._requests.decode(query)
        if commands and isinstance(commands[0], (CancelGoal, CallService)):
            self._look()
        if commands and isinstance(commands[0], SendGoal):
            return [*self._planner.look(), *commands]
        return commands

    def _refuse(self, query: zenoh.Query) -> None:
        self._requests.refuse(query, "the simulation has ended" if self._inbox.closed else "too many pending requests")

    def _look(self) -> None:
        """Report a new subscriber to the simulation at once, if the current query arrived after the last check."""
        if self._inbox.taken > self._looked:
            self._looked = self._inbox.arrived()
            self._report(self._publications.look())

    def _look_for_feedback(self, handler: ActionHandler) -> None:
        """Report new subscribers to feedback; in real time, subscribers to other topics are noticed soon anyway."""
        action = handler.action.name
        if self._hurries():
            self._look()
        elif self._inbox.taken > self._looked_for_feedback.get(action, -1):
            self._looked_for_feedback[action] = self._inbox.arrived()
            self._report(self._publications.look_for_feedback(action, of_world=handler.robot == WORLD))

    def _report(self, changes: int) -> None:
        if changes != self._changes_reported:
            self._changes_reported = changes
            self._submit(InterestChanged())

    def _interest_changed(self) -> None:
        with suppress(SimulationStopped):
            self._inbox.put(InterestChanged())

    def _gone(self, gid: bytes) -> None:
        """Drop the pending requests of a client that has gone; runs in a thread of Zenoh."""
        with suppress(SimulationStopped):
            for command in self._waiting.gone(gid.hex()):
                self._inbox.put(command)
