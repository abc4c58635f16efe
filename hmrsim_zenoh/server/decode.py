"""Decoding of the JSON wire's queries to commands.

An invalid query gets an error reply at once. Any other query travels with its command as ``reply_to`` and is answered
when the command has been processed.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import zenoh

from hmrsim.diagnostics import instead
from hmrsim.protocol.commands import CallService, CancelGoal, GetResult, Read, SendGoal
from hmrsim.protocol.goal import WORLD
from hmrsim.protocol.time import ReadTime
from hmrsim.protocol.topics import Topic
from hmrsim_zenoh.server.decode_time import ROBOT_TOPICS, SERVICE_TYPES, ReadRequest, TimeRequests, goal_id_in
from hmrsim_zenoh.server.replies import PendingExecution, PendingReply, SharedQuery, not_served
from hmrsim_zenoh.wire import encoding
from hmrsim_zenoh.wire.envelopes import (
    CancelGoalRequest,
    ExecuteRequest,
    GetResultRequest,
    SendGoalRequest,
    UnreadableError,
    around,
    plain,
    read_request,
)
from hmrsim_zenoh.wire.keys import ActionKey, TopicKey, Verb

if TYPE_CHECKING:
    from pydantic_core import SchemaValidator

    from hmrsim.actions import AnyAction
    from hmrsim.interfaces.message import Message
    from hmrsim.protocol.commands import AnyCommand
    from hmrsim.services import Service
    from hmrsim_zenoh.server.publisher import Publisher
    from hmrsim_zenoh.wire.access_control import AccessControl
    from hmrsim_zenoh.wire.keys import Keys

_log = logging.getLogger(__name__)

_KEPT_KEYS = 16_384

_Route = tuple[Callable[..., "list[AnyCommand]"], tuple[Any, ...]]
"""The method of `Requests` that decodes the queries on a key, and its arguments after the query."""


class _Target(NamedTuple):
    """A robot's action, as a key names it; *action* is None if it is unknown."""

    key: str
    robot: str
    name: str
    action: AnyAction | None


_WORLD_TOPICS = {"clock": Topic.CLOCK}


class Requests:
    """Decodes the queries of the JSON wire.

    The key of a query is parsed, and the method that decodes it is found, only for the first query on the key.

    Args:
        serves: The names of the actions of each robot.
        fixed: Latched topics of the world: topic to encoding and a function that returns the payload.
        max_payload: The largest request in bytes.
        publisher: Declares each key that is served when the first query on it comes.
        policy: The access control that the session enforces; None if it has none.
    """

    def __init__(
        self,
        keys: Keys,
        *,
        actions: Mapping[str, AnyAction],
        serves: Mapping[str, list[str]],
        fixed: Mapping[str, tuple[str, Callable[[], bytes]]],
        services: Mapping[str, Service],
        max_payload: int,
        publisher: Publisher,
        policy: AccessControl | None = None,
    ) -> None:
        self._keys = keys
        self._time_readers = TimeRequests(keys, actions, max_payload, policy).readers()
        self._services = services
        self._wakeup_key = keys.wakeup_key()
        self._routes: dict[str, _Route] = {}
        self._actions = actions
        self._serves = serves
        self._fixed = fixed
        self._values = {*fixed, *_WORLD_TOPICS, Topic.TIME.value}
        self._goals = [zenoh.KeyExpr(keys.any_action(verb)) for verb in (Verb.SEND_GOAL, Verb.EXECUTE)]
        self._max_payload = max_payload
        self._publisher = publisher

    def decode(self, query: zenoh.Query) -> list[AnyCommand]:
        """Return the commands of a query; an invalid query is answered here."""
        key = str(query.key_expr)
        try:
            read, parts = self._routes.get(key) or self._route(key)
            return read(self, query, *parts)
        except UnreadableError as error:
            PendingReply(query, key).refuse(error.to_json())
        except Exception:  # noqa: BLE001 - whatever a client sends, the simulation goes on
            _log.exception("reading a request on %s", key)
            PendingReply(query, key).refuse(encoding.error("the simulator has a bug: it can't read this request"))
        return []

    def _route(self, asked: str) -> _Route:
        """Return the route of the queries on a key expression, and keep it for further queries."""
        key = self._keys.without_history(asked)
        wild = "*" in key or "$" in key
        if key == self._wakeup_key or (key != asked and not (wild or self._reads(key))):
            # A query for the history must not become a command, as each client that may read may send one.
            route: _Route = Requests._ignore, ()
        elif wild:
            route = Requests._decode_wildcard, (key,)
        else:
            route = self._route_to(key)
        if len(self._routes) >= _KEPT_KEYS:
            self._routes.clear()
        self._routes[asked] = route
        return route

    def _reads(self, key: str) -> bool:
        """Return whether queries on a key read the latest value of a topic."""
        match self._keys.parse(key):
            case ActionKey(verb=verb):
                return verb is Verb.STATUS
            case TopicKey(robot, topic):
                return robot != WORLD or topic in self._values
        return False

    def _route_to(self, key: str) -> _Route:
        match self._keys.parse(key):
            case ActionKey(robot, action) as asked:
                route = self._route_to_action(key, asked)
                served = action in self._serves.get(robot, ()) or (robot == WORLD and action in self._actions)
            case TopicKey(robot, topic) if robot == WORLD:
                route, served = self._route_to_world(key, topic), True
            case TopicKey(robot, topic) if not robot.startswith("_") and not topic.startswith("_"):
                route, served = self._route_to_topic(key, robot, topic), True
            case None if self._keys.owner(key) in self._serves:
                raise UnreadableError(f"{self._keys.owner(key)} has no key {key!r}; see docs/reference/keys.md")
            case _:
                # Other programs, such as a planner, may serve keys below the prefix; they answer these queries.
                return Requests._ignore, ()
        if served:
            with suppress(zenoh.ZError):
                self._publisher.declare(key)
        return route

    def _route_to_action(self, key: str, asked: ActionKey) -> _Route:
        action = self._actions.get(asked.action)
        to = _Target(key, asked.robot, asked.action, action)
        match asked.verb:
            case Verb.SEND_GOAL:
                return Requests._send_goal, (to, _goal_reader(SendGoalRequest, action))
            case Verb.EXECUTE:
                return Requests._execute, (to, _goal_reader(ExecuteRequest, action))
            case Verb.CANCEL_GOAL:
                return Requests._cancel_goal, (to,)
            case Verb.GET_RESULT:
                return Requests._get_result, (to,)
            case Verb.STATUS:
                return Requests._read_value, (key, Read(Topic.STATUS, asked.robot, asked.action), action)
            case Verb.FEEDBACK:
                raise UnreadableError("feedback is only published; subscribe to it, or get the status")

    def _route_to_world(self, key: str, topic: str) -> _Route:
        if topic in self._time_readers:
            return Requests._decode_time, (key, self._time_readers[topic])
        if topic in self._services:
            kind: type[Message] = self._services[topic].request
            return Requests._call_service, (key, topic, plain(kind))
        if topic in _WORLD_TOPICS:
            return Requests._read_value, (key, Read(_WORLD_TOPICS[topic]))
        if topic in self._fixed:
            return Requests._read_fixed, (key, topic)
        known = ", ".join(sorted((*self._fixed, *_WORLD_TOPICS, *SERVICE_TYPES, *self._services)))
        raise UnreadableError(f"the world has no {topic!r} to get; there are: {known}")

    def _route_to_topic(self, key: str, robot: str, topic: str) -> _Route:
        if robot not in self._serves:
            raise UnreadableError(f"no robot {robot!r}{instead(robot, self._serves, verb='there are:')}")
        if topic not in ROBOT_TOPICS:
            raise UnreadableError(f"{robot} has no topic {topic!r} to get; it has: {', '.join(ROBOT_TOPICS)}")
        return Requests._read_value, (key, Read(ROBOT_TOPICS[topic], robot))

    def _ignore(self, query: zenoh.Query) -> list[AnyCommand]:
        query.drop()
        return []

    def _send_goal(self, query: zenoh.Query, to: _Target, reader: SchemaValidator) -> list[AnyCommand]:
        sent = self._read(reader, query)
        reply_to = PendingReply(query, to.key, to.action)
        return [SendGoal(to.robot, to.name, sent.goal if to.action else None, sent.goal_id, reply_to)]

    def _execute(self, query: zenoh.Query, to: _Target, reader: SchemaValidator) -> list[AnyCommand]:
        sent, timestamp = self._read(reader, query), self._publisher.timestamp
        both = PendingExecution(query, to.key, to.action, robot=to.robot, feedback=sent.feedback, timestamp=timestamp)
        return [SendGoal(to.robot, to.name, sent.goal if to.action else None, sent.goal_id, both, result_to=both)]

    def _cancel_goal(self, query: zenoh.Query, to: _Target) -> list[AnyCommand]:
        info = self._read(plain(CancelGoalRequest), query).goal_info
        goal_id, stamp = goal_id_in("goal_info.goal_id", info.goal_id), info.stamp.to_nanoseconds()
        return [CancelGoal(to.robot, to.name, goal_id, stamp, PendingReply(query, to.key, to.action))]

    def _get_result(self, query: zenoh.Query, to: _Target) -> list[AnyCommand]:
        goal_id = goal_id_in("goal_id", self._read(plain(GetResultRequest), query).goal_id)
        return [GetResult(to.robot, to.name, goal_id, PendingReply(query, to.key, to.action))]

    def _read_value(
        self, query: zenoh.Query, key: str, reading: Read, action: AnyAction | None = None
    ) -> list[AnyCommand]:
        self._check_reading(query)
        return [reading._replace(reply_to=PendingReply(query, key, action))]

    def _decode_time(self, query: zenoh.Query, key: str, read: Callable[[bytes, Any], AnyCommand]) -> list[AnyCommand]:
        payload = query.payload
        return [read(payload.to_bytes() if payload else b"", PendingReply(query, key))]

    def _call_service(self, query: zenoh.Query, key: str, name: str, reader: SchemaValidator) -> list[AnyCommand]:
        return [CallService(name, self._read(reader, query, empty=b"{}"), PendingReply(query, key))]

    def _read_fixed(self, query: zenoh.Query, key: str, topic: str) -> list[AnyCommand]:
        self._check_reading(query)
        mime, payload = self._fixed[topic]
        PendingReply(query, key).reply(payload(), mime)
        return []

    def _decode_wildcard(self, query: zenoh.Query, pattern: str) -> list[AnyCommand]:
        """Return a command to read each latched key that matches; with wildcards a query can only read."""
        wanted = zenoh.KeyExpr(pattern)
        fixed = [topic for topic in self._fixed if wanted.intersects(zenoh.KeyExpr(self._keys.world(topic)))]
        latched = [(key, reading) for key, reading in self._latched if wanted.intersects(key)]
        if not fixed and not latched and (query.payload is not None or any(map(wanted.intersects, self._goals))):
            raise UnreadableError("a request is for one robot and one action; name them, without wildcards")
        if fixed or latched:
            self._check_reading(query)
        for topic in fixed:
            mime, payload = self._fixed[topic]
            query.reply(self._keys.world(topic), payload(), encoding=mime)
        if not latched:
            query.drop()
        shared = SharedQuery(query, len(latched))
        return [reading._replace(reply_to=PendingReply(shared, str(key))) for key, reading in latched]

    @cached_property
    def _latched(self) -> list[tuple[zenoh.KeyExpr, Read | ReadTime]]:
        """All latched keys whose latest value is read in the simulation, and the commands that read it."""
        keys = self._keys
        of_world = [name for name, action in self._actions.items() if action.of_world]
        found: list[tuple[str, Read | ReadTime]] = [
            *((keys.world(name), Read(topic)) for name, topic in _WORLD_TOPICS.items()),
            (keys.world(Topic.TIME.value), ReadTime()),
            *(
                (keys.topic(robot, name), Read(topic, robot))
                for robot in self._serves
                for name, topic in ROBOT_TOPICS.items()
            ),
            *(
                (keys.action(*alias, Verb.STATUS), Read(Topic.STATUS, robot, action))
                for robot, actions in {**self._serves, WORLD: of_world}.items()
                for action in actions
                for alias in keys.names(robot, action)
            ),
        ]
        return [(zenoh.KeyExpr(key), reading) for key, reading in found]

    def _check_reading(self, query: zenoh.Query) -> None:
        if query.payload:
            self._read(plain(ReadRequest), query)

    def _read(self, reader: Any, query: zenoh.Query, *, empty: bytes = b"") -> Any:
        """Return the request in a query's payload; *empty* replaces an absent payload."""
        payload = query.payload
        return read_request(reader, payload.to_bytes() if payload else empty, self._max_payload)

    def refuse(self, query: zenoh.Query, reason: str, text: str) -> None:
        """Answer a query without decoding it, by an error or by the rejection of its goal."""
        key = str(query.key_expr)
        asked = self._keys.parse(key)
        if isinstance(asked, ActionKey) and asked.verb in (Verb.SEND_GOAL, Verb.EXECUTE):
            answer = not_served(asked.action, None, reason, text)
            PendingReply(query, key).reply(encoding.goal_response(answer), encoding.JSON)
        else:
            PendingReply(query, key).refuse(encoding.error(text))


def _goal_reader(envelope: type[SendGoalRequest[Any]], action: AnyAction | None) -> SchemaValidator:
    if action is None:
        return plain(envelope[dict[str, Any]])  # type: ignore[index]  # mypy does not know that it is generic
    message: type[Message] = action.goal
    return around(envelope, message)
