"""The server of the JSON wire, which turns queries into commands, and outputs into replies and publications.

The server keeps no table of goals: the query that awaits an answer travels with the command as its ``reply_to``. It
remembers only queries that await the feedback of a goal. All of it except `interest` runs in the simulation thread.
"""

from __future__ import annotations

import logging
import re
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, Final

import zenoh

from hmrsim.actions import registry as all_actions
from hmrsim.errors import SimulationStopped
from hmrsim.events.simulation import InternalError
from hmrsim.protocol.commands import Advance, CallService, CancelGoal, InterestChanged, SendGoal
from hmrsim.protocol.goal import WORLD, GoalResponse, Refused
from hmrsim.protocol.outputs import (
    Answered,
    EventStamped,
    FeedbackSent,
    GoalChanged,
    OrdersChanged,
    PlanWanted,
    RosterChanged,
    Sampled,
    StatusChanged,
)
from hmrsim.protocol.sinks import SelectiveSink
from hmrsim.protocol.time import TimeState
from hmrsim.protocol.topics import Topic
from hmrsim.services import registry as all_services
from hmrsim_zenoh.server.decode import Requests
from hmrsim_zenoh.server.external_planner import Planner
from hmrsim_zenoh.server.inbox import Reader
from hmrsim_zenoh.server.publisher import FeedbackLimiter, Publisher
from hmrsim_zenoh.server.replies import ENDED, PendingExecution, PendingReply, encoded, finish
from hmrsim_zenoh.server.tokens import MAX_TOKENS
from hmrsim_zenoh.wire import encoding
from hmrsim_zenoh.wire.keys import Verb, servers_own

if TYPE_CHECKING:
    from hmrsim.protocol.commands import AnyCommand, Command
    from hmrsim.settings.run import RunSettings
    from hmrsim_zenoh.server.inbox import QueryInbox
    from hmrsim_zenoh.server.interest import Interest
    from hmrsim_zenoh.server.world_info import Description
    from hmrsim_zenoh.wire.keys import Keys

_log = logging.getLogger(__name__)

_BUSY = "too many requests are waiting; try again later"

_LOG = "log"
"""The key of the events that a trace contains, with the messages of goals. They are few if robots only drive."""

_CHANGES_ROSTER: Final = re.compile(r"/(spawn_entity|spawn_entities|delete_entity)(/|$)")
"""Finds the services that add and remove robots, in the keys of each wire."""

_OF_GOALS: Final[tuple[Topic | str, ...]] = (Topic.STATUS, Topic.FEEDBACK, Topic.EVENTS, Topic.MOTION, _LOG)
"""The topics on which a goal's events are published as soon as it is accepted."""

_UNHEARD: Final = frozenset({GoalChanged, StatusChanged, FeedbackSent, Sampled, EventStamped})
"""The outputs that are dropped without a subscriber."""


class Server(SelectiveSink):
    """Serves one simulation on one session.

    Args:
        session: An open session, which the caller closes.
        submit: Processes commands at once, in the simulation thread.
        on_roster: Called after robots have come or gone, or the world was replaced, once for many of them. It has to
            call `follow`.
        settings: The limits of request sizes and of an external planner's time.
        interest: Starts to detect subscribers, with the arguments of `SubscriberWatch`.

    Attributes:
        keys: How keys are spelled, with the aliases of actions.
    """

    varies = True

    def __init__(
        self,
        session: zenoh.Session,
        keys: Keys,
        description: Description,
        *,
        submit: Callable[[Command], None],
        on_roster: Callable[[], None],
        settings: RunSettings,
        inbox: QueryInbox,
        interest: Callable[..., Interest[Topic | str]],
    ) -> None:
        self._submit = submit
        self._description = description
        self.keys = keys
        self._actions = all_actions()
        self._limiter = FeedbackLimiter()
        # The queries that await feedback, by robot, action and goal id.
        self._followed: dict[tuple[str, str, str], PendingExecution] = {}
        self._goal_keys: dict[tuple[str, str, Verb], list[str]] = {}
        self._publisher = Publisher(session, declares=len(description.serves) <= MAX_TOKENS)
        self._fixed = description.latched
        self._read_by = partial(
            Requests,
            actions=self._actions,
            fixed=self._fixed,
            services=all_services(),
            max_payload=settings.max_payload,
            publisher=self._publisher,
            policy=description.policy,
        )
        self._requests = self._read_by(keys, serves=description.serves)
        self._inbox = inbox
        own, reader = servers_own(keys.everything()), Reader(self._decode, self._refuse)
        inbox.open(session, own, reader, wakeup_key=keys.wakeup_key())
        self.planner = Planner(
            session,
            keys,
            self._inbox.put,
            wanted=lambda: description.plans_externally,
            timeout=settings.planner_timeout,
            max_payload=settings.max_payload,
        )
        self._emitters: dict[type, Callable[[Any], None]] = {
            Answered: self._emit_answer,
            GoalChanged: self._emit_change,
            StatusChanged: self._emit_status,
            FeedbackSent: self._emit_feedback,
            Sampled: self._emit_sample,
            EventStamped: self._put_event,
            TimeState: self._emit_time,
            RosterChanged: self._mark_roster,
            OrdersChanged: lambda _output: self._put_fixed("demand"),
            PlanWanted: self.planner.ask,
        }
        self._on_roster = on_roster
        self._roster_changed = False
        self._finishing = False
        self._changes_reported = 0
        self._looked = -1
        self._looked_for_goals = -1
        self._interest = interest(session, _patterns(keys), keys.everything(), self._interest_changed)
        self._history = session.declare_queryable(
            servers_own(keys.history()), zenoh.handlers.Callback(self._inbox.put_query), complete=False
        )

    def follow(self) -> None:
        """Serve the current robots and publish the latched topics to their subscribers."""
        serves = self._description.serves
        before, self.keys = self.keys, replace(self.keys, aliases=self._description.aliases)
        self._requests = self._read_by(self.keys, serves=serves)
        there, renamed = {*serves, WORLD}, before.aliases != self.keys.aliases
        self._goal_keys.clear()
        self._publisher.forget(lambda key: renamed or self.keys.owner(key) not in there)
        for topic in self._fixed:
            self._put_fixed(topic)

    def _put_fixed(self, topic: str) -> None:
        """Publish a latched topic of the world if it has subscribers."""
        mime, payload = self._fixed[topic]
        if self._interest.in_key(self.keys.world(topic)):
            self._publisher.put(self.keys.world(topic), payload(), mime, reliable=True)

    def join(self) -> None:
        """Wait for all threads to end, after the session was closed."""
        self._interest.join()

    def finish(self, submit: Callable[[AnyCommand], None], answer: Callable[[Any, Any], None]) -> None:
        """Answer the queries on all wires that still wait when the simulation has ended.

        Args:
            submit: Processes all commands except new goals and services.
            answer: Sends the answer to these.
        """
        self._finishing = True
        finish(self._inbox, submit, answer)

    def before(self, command: AnyCommand) -> list[AnyCommand]:
        """Return the commands to process before one of a client in this process: changes of planner and subscribers."""
        first: list[AnyCommand] = []
        if self._description.plans_externally and isinstance(command, (SendGoal, Advance)):
            first += self.planner.look()
        if (changes := self._interest.look()) != self._changes_reported:
            self._changes_reported = changes
            first.append(InterestChanged())
        return first

    def _decode(self, query: zenoh.Query) -> list[AnyCommand]:
        if self._finishing and "*" in str(query.key_expr):
            # Thousands of queries that read everything may be waiting, and answering them would delay the end.
            self._refuse(query)
            return []
        commands = self._requests.decode(query)
        if commands and isinstance(commands[0], (Advance, CancelGoal, CallService)):
            self._look()
        if self._description.plans_externally and commands and isinstance(commands[0], (SendGoal, Advance)):
            return [*self.planner.look(), *commands]
        return commands

    def _look(self) -> None:
        """Report new subscribers to the simulation, if the current query arrived after the last look."""
        if self._inbox.taken > self._looked:
            self._looked = self._inbox.arrived()
            self._report(self._interest.look())

    def _look_for_goals(self) -> None:
        """Report new subscribers of a goal's topics, so that a client that subscribes before its goal misses nothing.

        In real time, subscribers of other topics are noticed soon enough.
        """
        if self._description.hurries():
            self._look()
        elif self._inbox.taken > max(self._looked, self._looked_for_goals):
            self._looked_for_goals = self._inbox.arrived()
            self._report(self._interest.look(_OF_GOALS))

    def _report(self, changes: int) -> None:
        if changes != self._changes_reported:
            self._changes_reported = changes
            self._submit(InterestChanged())

    def _mark_roster(self, _event: RosterChanged) -> None:
        self._roster_changed = True
        self._inbox.prepare(self._settle)

    def _settle(self, query: zenoh.Query | None = None) -> bool:
        """Serve the current robots, unless the next query changes them again, since this takes time for each robot."""
        if query is not None and _CHANGES_ROSTER.search(str(query.key_expr)):
            return False
        if self._roster_changed:
            self._roster_changed = False
            self._on_roster()
        return True

    def _refuse(self, query: zenoh.Query) -> None:
        reason, text = ("not_ready", ENDED) if self._inbox.closed else ("busy", _BUSY)
        self._requests.refuse(query, reason, text)

    def _interest_changed(self) -> None:
        try:
            self._inbox.put(InterestChanged())
        except SimulationStopped:
            _log.debug("interest changed after the simulation had ended")

    def wants(self, topic: Topic) -> bool:
        """Return whether a topic has a subscriber."""
        if topic is Topic.FEEDBACK and self._followed:
            return True
        return self._interest[topic] or (topic is Topic.EVENTS and self._interest[_LOG])

    def handler_for(self, kind: type) -> Callable[[Any], object] | None:
        """Return the function that processes outputs of a type; None to ignore them."""
        # The limiter has to learn of the ends of goals whose feedback it has passed.
        if kind in _UNHEARD and not (self._interest.any or self._followed or self._limiter.sent):
            return None
        return self._emitters.get(kind)

    def _emit_answer(self, event: Answered) -> None:
        asked = event.reply_to
        if not isinstance(asked, PendingReply):
            return
        answer = event.answer
        try:
            if isinstance(answer, Refused):
                asked.refuse(encoding.error(answer.message, answer.field, answer.value))
            elif isinstance(answer, GoalResponse):
                self._answer_goal(asked, answer)
            else:
                asked.reply(*encoded(answer, asked.action))
        except Exception:
            # For example, JSON can't state the result of an action.
            asked.refuse(encoding.error("the simulator has a bug: it can't write this answer"))
            raise

    def _answer_goal(self, asked: PendingReply, answer: GoalResponse) -> None:
        if answer.accepted and isinstance(asked, PendingExecution):
            asked.send(*encoded(answer, asked.action))
            self._follow(asked, answer.goal_id)
        else:
            asked.reply(*encoded(answer, asked.action))
        self._look_for_goals()

    def _follow(self, asked: PendingExecution, goal_id: str) -> None:
        """Send the feedback of a goal to the query that sent the goal, if the query awaits feedback."""
        if asked.feedback and asked.action is not None:
            news = not self.wants(Topic.FEEDBACK)
            self._followed[asked.robot, asked.action.name, goal_id] = asked
            if news:
                self._submit(InterestChanged())

    def _emit_change(self, event: GoalChanged) -> None:
        if event.status.terminal:
            self._limiter.forget(event.goal_id)
            followed = self._followed.pop((event.robot, event.action, event.goal_id), None)
            if followed and not self._followed:
                self._interest_changed()
        if event.goal is not None and self._interest[_LOG]:
            accepted = encoding.event_payload(EventStamped(event.stamp, event.accepted()))
            self._publisher.put(self.keys.world(_LOG), accepted, encoding.EVENT, reliable=True)
        self._put_event(event)

    def _put_event(self, event: GoalChanged | EventStamped) -> None:
        watched, logged = self._interest[Topic.EVENTS], self._interest[_LOG]
        if logged and isinstance(event, EventStamped):
            logged = event.event.traced or isinstance(event.event, InternalError)
        if not (watched or logged):
            return
        payload = encoding.event_payload(event)
        for topic in ("events",) * watched + (_LOG,) * logged:
            self._publisher.put(self.keys.world(topic), payload, encoding.EVENT, reliable=True)

    def _emit_status(self, event: StatusChanged) -> None:
        self._settle()
        if self._interest[Topic.STATUS]:
            payload = encoding.status_array(event)
            for key in self._keys_of(event, Verb.STATUS):
                self._publisher.put(key, payload, encoding.STATUS, reliable=True)

    def _emit_feedback(self, event: FeedbackSent) -> None:
        self._settle()
        listened, query = self._interest[Topic.FEEDBACK], self._followed.get((event.robot, event.action, event.goal_id))
        if not ((listened or query) and self._limiter.passes(event)):
            return
        payload = encoding.feedback_message(event.goal_id, event.feedback)
        mime = encoding.of_action(self._actions[event.action], "FeedbackMessage")
        for key in self._keys_of(event, Verb.FEEDBACK) if listened else ():
            self._publisher.put(key, payload, mime)
        if query:
            query.send(payload, mime)

    def _emit_sample(self, event: Sampled) -> None:
        self._settle()
        if not self._interest[event.topic]:
            return
        key = self.keys.topic(event.robot or WORLD, event.topic.value)
        self._publisher.put(key, encoding.message(event.message), encoding.of_message(event.message))

    def _emit_time(self, event: TimeState) -> None:
        payload, mime, _ = encoded(event)
        self._publisher.put(self.keys.world(Topic.TIME.value), payload, mime, reliable=True)

    def _keys_of(self, event: StatusChanged | FeedbackSent, verb: Verb) -> list[str]:
        """Return the keys of one verb of a robot's action, one for each of its names."""
        target = (event.robot, event.action, verb)
        if target not in self._goal_keys:
            self._goal_keys[target] = [self.keys.action(*name, verb) for name in self.keys.names(*target[:2])]
        return self._goal_keys[target]


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
