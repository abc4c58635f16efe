"""The JSON wire of a simulation: a query becomes a command, an event becomes a reply or a publication.

The server keeps no table of goals: whom an answer is for travels with the command as its ``reply_to``. All of it
but `interest` runs in the simulation's thread.
"""

from __future__ import annotations

import logging
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import zenoh

from hmrsim.errors import SimulationStopped
from hmrsim.interfaces.message import Message
from hmrsim.protocol.answers import CancelResponse, GoalResponse, Refused, ResultResponse
from hmrsim.protocol.commands import Advance, CallService, CancelGoal, InterestChanged, SendGoal
from hmrsim.protocol.goal import WORLD
from hmrsim.protocol.outputs import (
    Answered,
    FeedbackSent,
    GoalChanged,
    Granted,
    Happened,
    PlanWanted,
    RosterChanged,
    Sampled,
    StatusChanged,
)
from hmrsim.protocol.time import HasLeft, Joined, TimeState
from hmrsim.protocol.topics import Topic
from hmrsim_zenoh.server.decode import PendingReply, Requests
from hmrsim_zenoh.server.decode_time import TIME_STATE, encoded
from hmrsim_zenoh.server.external_planner import Planner
from hmrsim_zenoh.server.inbox import QueryInbox
from hmrsim_zenoh.server.interest import SubscriberWatch
from hmrsim_zenoh.server.liveliness import MAX_TOKENS
from hmrsim_zenoh.server.rate_limit import Thinning
from hmrsim_zenoh.wire import encoding
from hmrsim_zenoh.wire.keys import Verb

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from hmrsim.actions import AnyAction
    from hmrsim.protocol.commands import AnyCommand, Command
    from hmrsim.protocol.outputs import Event
    from hmrsim.services import AnyService
    from hmrsim.settings.run import RunSettings
    from hmrsim_zenoh.server.world_info import Description
    from hmrsim_zenoh.wire.keys import Keys

_log = logging.getLogger(__name__)

_BUSY = "too many requests are waiting; try again later"
_ENDED = "the simulation has ended"

_LOG = "log"
"""The key of events that people read: those of which a trace has some. They are few where robots only drive."""

_BLOCK, _DROP = zenoh.CongestionControl.BLOCK, zenoh.CongestionControl.DROP


class Server:
    """Serves one simulation on one session.

    Args:
        session: An open session; it stays the caller's to close.
        keys: How keys are spelled.
        description: What it tells of the simulation, and which actions each robot has.
        actions: All actions by name, to read goals.
        services: The world's services by name.
        submit: Takes commands at once, in the simulation's thread.
        on_roster: Called when robots come or go, or all of the world is another. It is to `follow`.
        settings: How large requests may be, and how long a planner outside may take.

    Attributes:
        inbox: Brings commands in.
        planner: The one outside.
    """

    def __init__(
        self,
        session: zenoh.Session,
        keys: Keys,
        description: Description,
        *,
        actions: Mapping[str, AnyAction],
        services: Mapping[str, AnyService],
        submit: Callable[[Command], None],
        on_roster: Callable[[], None],
        settings: RunSettings,
    ) -> None:
        self._session = session
        self._submit = submit
        self._description = description
        self._declares = len(description.serves) <= MAX_TOKENS
        self._keys = keys
        self._actions = actions
        self._thinning = Thinning()
        # Where each is published, by the name that it is known by here.
        self._feedback_keys: dict[tuple[str, str], list[zenoh.KeyExpr | str]] = {}
        self._status_keys: dict[tuple[str, str], list[zenoh.KeyExpr | str]] = {}
        self._topic_keys: dict[str, zenoh.KeyExpr | str] = {}
        self._emitters: dict[type, Callable[[Any], None]] = {
            Answered: self._emit_answer,
            GoalChanged: self._emit_change,
            StatusChanged: self._emit_status,
            FeedbackSent: self._emit_feedback,
            Sampled: self._emit_sample,
            Happened: self._emit_happening,
            TimeState: self._emit_time,
            RosterChanged: lambda _event: on_roster(),
            PlanWanted: self._emit_plan_wanted,
        }
        self._fixed = description.latched
        self._read_by = partial(
            Requests, actions=actions, fixed=self._fixed, services=services, max_payload=settings.max_payload
        )
        self._requests = self._read_by(keys, serves=description.serves)
        self.inbox = QueryInbox(
            session,
            keys.everything(),
            decode=self._decode,
            refuse=self._refuse,
            wakeup_key=keys.wakeup_key(),
        )
        self.planner = Planner(
            session, keys, self.inbox.put, timeout=settings.planner_timeout, max_payload=settings.max_payload
        )
        self._changes_told = 0
        self._interest = SubscriberWatch(session, _patterns(keys), keys.everything(), self._interest_changed)
        self._history = session.declare_queryable(
            keys.history(), zenoh.handlers.Callback(self.inbox.put_query), complete=False
        )

    def follow(self) -> None:
        """Serve the robots that are there now; who subscribes to what is latched is told."""
        self._keys = replace(self._keys, aliases=self._description.aliases)
        self._requests = self._read_by(self._keys, serves=self._description.serves)
        self._feedback_keys.clear()
        self._status_keys.clear()
        for topic, (mime, payload) in self._fixed.items():
            if self._interest.in_key(self._keys.world(topic)):
                self._put(self._key_of(self._keys.world(topic)), payload(), mime, reliable=True)

    def close(self) -> None:
        """Take no more queries; the simulation's thread wakes and ends."""
        self.inbox.close()

    def join(self) -> None:
        """Wait until nothing of it runs any more, after the session was closed."""
        self._interest.join()

    def finish(self, submit: Callable[[AnyCommand], None], answer: Callable[[Any, Any], None]) -> None:
        """Answer what waits still when the simulation has ended, on whichever wire it came.

        Args:
            submit: Takes all but new goals and services.
            answer: Sends the answer to those.
        """
        self.close()
        while (command := self.inbox.poll()) is not None:
            if isinstance(command, SendGoal):
                refusal = self._requests.not_served(command.action, command.goal_id, "not_ready", _ENDED)
                answer(command.reply_to, refusal)
            elif isinstance(command, CallService):
                answer(command.reply_to, Refused("", None, _ENDED))
            else:
                submit(command)

    def _decode(self, query: zenoh.Query) -> list[AnyCommand]:
        commands = self._requests.decode(query)
        if commands and isinstance(commands[0], (Advance, CancelGoal, CallService)):
            self._look()
        if commands and isinstance(commands[0], (SendGoal, Advance)):
            return [*self.planner.look(), *commands]
        return commands

    def _look(self) -> None:
        """Tell the simulation at once if somebody has come to listen."""
        changes = self._interest.look()
        if changes != self._changes_told:
            self._changes_told = changes
            self._submit(InterestChanged())

    def _refuse(self, query: zenoh.Query) -> None:
        reason, text = ("not_ready", _ENDED) if self.inbox.closed else ("busy", _BUSY)
        self._requests.refuse(query, reason, text)

    def _interest_changed(self) -> None:
        try:
            self.inbox.put(InterestChanged())
        except SimulationStopped:
            _log.debug("interest changed after the simulation had ended")

    # --- events to replies and publications -----------------------------------------------------------------------

    def wants(self, topic: Topic) -> bool:
        """Return whether anybody subscribes to a topic."""
        return self._interest[topic] or (topic is Topic.EVENTS and self._interest[_LOG])

    def emit(self, event: Event) -> None:
        """Send an event to whom it concerns."""
        self._emitters[type(event)](event)

    def _emit_answer(self, event: Answered) -> None:
        asked = event.reply_to
        if not isinstance(asked, PendingReply):
            return
        answer, action = event.answer, asked.action
        match answer:
            case GoalResponse():
                mime = encoding.of_action(action, "SendGoal_Response") if action else encoding.JSON
                asked.reply(encoding.goal_response(answer), mime)
                # Who subscribes and then sends a goal must see all of it; what is to be seen comes after this answer.
                self._look()
            case CancelResponse():
                asked.reply(encoding.cancel_response(answer), encoding.CANCEL_RESPONSE)
            case ResultResponse():
                mime = encoding.of_action(action, "GetResult_Response") if action else encoding.JSON
                asked.reply(encoding.result_response(answer), mime)
            case StatusChanged():
                asked.reply(encoding.status_array(answer), encoding.STATUS)
            case Sampled(message=message):
                asked.reply(encoding.message(message), encoding.of_message(message))
            case Refused(field, value, text):
                asked.refuse(encoding.error(text, field, value))
            case Message():
                asked.reply(encoding.message(answer), encoding.of_message(answer))
            case Granted() | Joined() | HasLeft() | TimeState():
                asked.reply(*encoded(answer))

    def _emit_change(self, event: GoalChanged) -> None:
        if event.status.terminal:
            self._thinning.forget(event.goal_id)
        self._put_event(event)

    def _emit_happening(self, event: Happened) -> None:
        self._put_event(event)

    def _put_event(self, event: GoalChanged | Happened) -> None:
        watched, logged = self._interest[Topic.EVENTS], self._interest[_LOG]
        if logged and isinstance(event, Happened):
            logged = event.event.traced
        if not (watched or logged):
            return
        payload = encoding.happened(event)
        for topic in ("events",) * watched + (_LOG,) * logged:
            self._put(self._key_of(self._keys.world(topic)), payload, encoding.EVENT, reliable=True)

    def _emit_status(self, event: StatusChanged) -> None:
        if self._interest[Topic.STATUS]:
            payload = encoding.status_array(event)
            for key in self._keys_of(self._status_keys, event, Verb.STATUS):
                self._put(key, payload, encoding.STATUS, reliable=True)

    def _emit_feedback(self, event: FeedbackSent) -> None:
        if not (self._interest[Topic.FEEDBACK] and self._thinning.passes(event)):
            return
        payload = encoding.feedback_message(event.goal_id, event.feedback)
        mime = encoding.of_action(self._actions[event.action], "FeedbackMessage")
        for key in self._keys_of(self._feedback_keys, event, Verb.FEEDBACK):
            self._put(key, payload, mime)

    def _emit_sample(self, event: Sampled) -> None:
        if not self._interest[event.topic]:
            return
        key = self._key_of(self._keys.topic(event.robot or WORLD, event.topic.value))
        self._put(key, encoding.message(event.message), encoding.of_message(event.message))

    def _emit_time(self, event: TimeState) -> None:
        self._put(self._key_of(self._keys.world(Topic.TIME.value)), encoded(event)[0], TIME_STATE, reliable=True)

    def _emit_plan_wanted(self, event: PlanWanted) -> None:
        self.planner.ask(event)

    def _put(self, key: zenoh.KeyExpr | str, payload: bytes, mime: str, *, reliable: bool = False) -> None:
        """Publish; what may be lost is dropped rather than waited for when a reader is slow."""
        try:
            self._session.put(key, payload, encoding=mime, congestion_control=_BLOCK if reliable else _DROP)
        except zenoh.ZError as error:
            _log.debug("publishing on %s: %s", key, error)

    def _keys_of(
        self, known: dict[tuple[str, str], list[zenoh.KeyExpr | str]], event: StatusChanged | FeedbackSent, verb: Verb
    ) -> list[zenoh.KeyExpr | str]:
        """Return the keys of one verb of a robot's action, one for each of its names."""
        target = (event.robot, event.action)
        if target not in known:
            known[target] = [self._declared(self._keys.action(*name, verb)) for name in self._keys.names(*target)]
        return known[target]

    def _key_of(self, topic: str) -> zenoh.KeyExpr | str:
        if topic not in self._topic_keys:
            self._topic_keys[topic] = self._declared(topic)
        return self._topic_keys[topic]

    def _declared(self, key: str) -> zenoh.KeyExpr | str:
        """Return a key as Zenoh knows it best.

        Zenoh compares a key that it does not know with all that it does: half a millisecond where 1,000 robots have
        liveliness tokens. So all are declared there, and none in larger worlds, which have no tokens and where it
        would take minutes.
        """
        if not self._declares:
            return key
        try:
            declared: zenoh.KeyExpr = self._session.declare_keyexpr(key)
        except zenoh.ZError:
            # The session was closed, as whoever publishes will find out, too.
            return key
        return declared


def _patterns(keys: Keys) -> dict[Topic | str, str]:
    """Return the keys on which each topic is published."""
    return {
        Topic.STATUS: keys.any_action(Verb.STATUS),
        Topic.FEEDBACK: keys.any_action(Verb.FEEDBACK),
        **{topic: keys.any_topic(topic.value) for topic in (Topic.ODOM, Topic.BATTERY_STATE, Topic.DETECTIONS)},
        Topic.CLOCK: keys.world("clock"),
        Topic.EVENTS: keys.world("events"),
        Topic.MOTION: keys.world("events"),
        _LOG: keys.world(_LOG),
        Topic.TIME: keys.world("time/state"),
    }
