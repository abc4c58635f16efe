"""Decoding of the requests about time, ``_world/time/…``, with the commands and conditions of an advance."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from functools import cache, lru_cache, partial
from itertools import repeat
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal

import zenoh
from pydantic import AfterValidator, Field, SkipValidation, ValidationError
from pydantic_core import to_json

from hmrsim.interfaces.builtin_interfaces import MAX_NANOSECONDS, NANOSECONDS
from hmrsim.interfaces.quantities import REAL_TIME_FACTOR
from hmrsim.protocol.commands import Advance, CancelGoal, GetResult, SendGoal, Unreadable
from hmrsim.protocol.goal import WORLD, parse_goal_id
from hmrsim.protocol.time import Join, Leave, ReadTime, SetClock
from hmrsim.protocol.topics import ORDERS, Comparison, Topic, Unwatch, Watch
from hmrsim_zenoh.wire.envelopes import (
    MAX_TEXT,
    Envelope,
    UnreadableError,
    check_texts_of,
    plain,
    read_often,
    read_request,
    unreadable,
    unreadable_at,
)
from hmrsim_zenoh.wire.keys import ActionKey, Keys, TopicKey, Verb

if TYPE_CHECKING:
    from hmrsim.actions import AnyAction
    from hmrsim.interfaces.message import Message
    from hmrsim.protocol.commands import TimeCommand
    from hmrsim_zenoh.wire.access_control import AccessControl
    from hmrsim_zenoh.wire.keys import Keys

_KEPT: Final = 1024

SERVICE_TYPES: Final = {
    "time/join": "hmrsim/Join",
    "time/advance": "hmrsim/Advance",
    "time/leave": "hmrsim/Leave",
    "time/set": "hmrsim/SetTime",
    "time/state": "hmrsim/TimeState",
}
"""The requests and their types."""

MAX_COMPARISONS: Final = 20
"""The comparisons of a condition."""

_OPERATORS: Final = ("==", "!=", *ORDERS)
ROBOT_TOPICS: Final = {"odom": Topic.ODOM, "battery_state": Topic.BATTERY_STATE, "detections": Topic.DETECTIONS}
"""The topics of a robot with a current value."""
_ESCAPED: Final = re.compile(r"~[01]")

_Text = Annotated[str, Field(max_length=MAX_TEXT)]
_Comparison = Annotated[list[_Text | bool | int | float | None], Field(min_length=3, max_length=3)]
_Name = Annotated[str, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_]*$", max_length=200)]
_Kind = Literal["status", "feedback", "result"]


class WatchRequest(Envelope):
    """A condition that stops time once: all comparisons hold in one message of a topic."""

    watch: _Text = Field(description="The participant's name for the condition.")
    key: _Text = Field(description="The topic, without the prefix.")
    when: list[_Comparison] = Field(
        default_factory=list, max_length=MAX_COMPARISONS, description="JSON pointer, operator and value of each."
    )


class UnwatchRequest(Envelope):
    """The request to stop watching a condition."""

    unwatch: _Text


class JoinRequest(Envelope):
    """The request to join lockstep; one that is repeated with the same token gets the same answer."""

    name: _Name
    token: Annotated[str, Field(max_length=200)] = ""


class LeaveRequest(Envelope):
    """The request to leave lockstep."""

    participant: str


class CommandRequest(Envelope):
    """A goal to send or to cancel before time moves, or one whose result is wanted."""

    robot: str
    action: str
    goal_id: str | None = None
    goal: dict[str, Any] | None = None
    cancel: str | None = None
    result: str | None = None


class AdvanceRequest(Envelope):
    """The request to advance: the time limit, the events that stop it, and the commands to apply first."""

    participant: str
    epoch: int
    until: Annotated[float, Field(lt=MAX_NANOSECONDS / NANOSECONDS)] | None = None
    wake: list[_Kind] = Field(default_factory=list)
    report: list[_Kind] = Field(default_factory=list)
    # Read one by one: each has its own answer.
    commands: list[SkipValidation[CommandRequest | WatchRequest | UnwatchRequest]] = Field(default_factory=list)


class SetRequest(Envelope):
    """The request to change the clock; omitted fields keep their values."""

    clock: Literal["realtime", "lockstep"] | None = None
    real_time_factor: Annotated[float, AfterValidator(REAL_TIME_FACTOR.checked)] | None = None


class ReadRequest(Envelope):
    """The request to read a latched value: it has no fields."""


class TimeRequests:
    """Decodes the requests about time.

    Args:
        keys: How keys are spelled, including the aliases of actions.
        max_payload: The largest request in bytes.
        policy: The access control that the session enforces; None if it has none. Members with restricted rights
            advance on the key `advance/NAME`, which shows whose rights apply to each command.
    """

    def __init__(
        self, keys: Keys, actions: Mapping[str, AnyAction], max_payload: int, policy: AccessControl | None = None
    ) -> None:
        self._members = policy.rules if policy else ()
        self._denial = lru_cache(_KEPT)(policy.denial if policy else _no_denial)
        self._keys = keys
        self._resolve = lru_cache(_KEPT)(keys.resolve)
        self._actions = actions
        self._max_payload = max_payload

    def readers(self) -> dict[str, Callable[[bytes, Any], TimeCommand]]:
        """Return the reader of each topic of the world that is a request about time.

        It returns the command of a payload and a ``reply_to``, and raises an `UnreadableError` if the payload is
        invalid.
        """
        return {
            "time/join": self._read_join,
            "time/advance": self._read_advance,
            "time/leave": self._read_leave,
            "time/set": self._read_set,
            "time/state": self._read_state,
            **{f"time/advance/{member}": partial(self._read_advance, member=member) for member in self._members},
        }

    def _request(self, kind: type[Envelope], payload: bytes) -> Any:
        return read_request(plain(kind), payload, self._max_payload)

    def _read_join(self, payload: bytes, reply_to: Any) -> Join:
        request: JoinRequest = self._request(JoinRequest, payload)
        return Join(request.name, reply_to, request.token)

    def _read_leave(self, payload: bytes, reply_to: Any) -> Leave:
        return Leave(self._request(LeaveRequest, payload).participant, reply_to)

    def _read_set(self, payload: bytes, reply_to: Any) -> SetClock:
        request = self._request(SetRequest, payload)
        return SetClock(request.clock, request.real_time_factor, reply_to)

    def _read_state(self, payload: bytes, reply_to: Any) -> ReadTime:
        if payload:
            self._request(ReadRequest, payload)
        return ReadTime(reply_to)

    def _read_advance(self, payload: bytes, reply_to: Any, member: str = "") -> Advance:
        request: AdvanceRequest = read_request(plain(AdvanceRequest), payload, self._max_payload)
        return Advance(
            request.participant,
            request.epoch,
            math.inf if request.until is None else request.until,
            _kinds(tuple(request.wake)),
            _kinds(tuple(request.report)),
            tuple(map(self._command, request.commands, repeat(member), repeat(len(payload)))),
            reply_to,
        )

    def _command(
        self, item: object, member: str, size: int
    ) -> SendGoal | CancelGoal | GetResult | Watch | Unwatch | Unreadable:
        try:
            # Patterns would take as long as all of the rest.
            if isinstance(item, dict):
                if "watch" in item:
                    return condition(plain(WatchRequest).validate_python(item), self._keys)
                if "unwatch" in item:
                    return condition(plain(UnwatchRequest).validate_python(item), self._keys)
                if _sends_goal(item):
                    # Nearly all commands are such ones; a `CommandRequest` would be one more pass.
                    robot, name = item["robot"], item["action"]
                    if member:
                        self._check_rights(member, robot, name, Verb.SEND_GOAL)
                    return self._goal(robot, name, item["goal"], item.get("goal_id"), size)
            request: CommandRequest = plain(CommandRequest).validate_python(item)
            if size > MAX_TEXT:
                check_texts_of(request)
            return self._command_of(request, member, size)
        except ValidationError as error:
            return Unreadable(unreadable(error).to_json())
        except UnreadableError as error:
            return Unreadable(error.to_json())

    def _command_of(self, request: CommandRequest, member: str, size: int) -> SendGoal | CancelGoal | GetResult:
        robot, name = self._resolve(request.robot, request.action)
        command: SendGoal | CancelGoal | GetResult
        match request.goal, request.cancel, request.result:
            case None, str(cancel), None if request.goal_id is None:
                verb, command = Verb.CANCEL_GOAL, CancelGoal(robot, name, goal_id_in("cancel", cancel))
            case None, None, str(result) if request.goal_id is None:
                verb, command = Verb.GET_RESULT, GetResult(robot, name, goal_id_in("result", result))
            case dict(goal), None, None:
                verb, command = Verb.SEND_GOAL, self._goal(robot, name, goal, request.goal_id, size)
            case _:
                raise UnreadableError("a command has either a goal to send, or the id of one as cancel or as result")
        if member:
            self._check_rights(member, request.robot, request.action, verb)
        return command

    def _goal(self, robot: str, name: str, goal: dict[str, Any], goal_id: str | None, size: int) -> SendGoal:
        robot, name = self._resolve(robot, name)
        action = self._actions.get(name)
        if action is None:
            # The simulation rejects it.
            return SendGoal(robot, name, None, goal_id)
        kind: type[Message] = action.goal
        try:
            message: Message = plain(kind).validate_python(goal)
            if size > MAX_TEXT:
                check_texts_of(message)
        except ValidationError as error:
            raise unreadable(error).below("goal") from None
        except UnreadableError as error:
            raise error.below("goal") from None
        return SendGoal(robot, name, message, goal_id)

    def _check_rights(self, member: str, robot: str, name: str, verb: Verb) -> None:
        """Check that a member may send a command that belongs to a key.

        Raises:
            UnreadableError: It may not.
        """
        key = self._keys.action(robot, name, verb)
        try:
            denial = self._denial(member, key)
        except zenoh.ZError:
            denial = f"{key!r} is not a key of an action"
        if denial:
            raise UnreadableError(denial)


def _sends_goal(item: dict[str, Any]) -> bool:
    """Return whether a command has the fields of a goal to send, and no others."""
    robot, name, goal_id = item.get("robot"), item.get("action"), item.get("goal_id")
    return (
        type(robot) is type(name) is str
        and type(item.get("goal")) is dict
        and (goal_id is None or type(goal_id) is str)
        and len(item) == 3 + ("goal_id" in item)
        and len(robot) <= MAX_TEXT >= len(name)
    )


def goal_id_in(field: str, text: str) -> str:
    """Return the goal id in a field of a request.

    Raises:
        UnreadableError: The text is not a goal id.
    """
    try:
        return parse_goal_id(text)
    except ValueError as error:
        raise unreadable_at(field, str(error), text) from None


def read_goal(kind: type[Message], goal: Mapping[str, Any]) -> Message:
    """Return the goal that plain values in the field ``goal`` of a request make.

    Raises:
        UnreadableError: They are not of the goal's type.
    """
    # Encoded as JSON again, so that a list or a number is validated as in any other request.
    payload = to_json(goal, inf_nan_mode="constants")
    try:
        message: Message = read_often(plain(kind), payload)
        if len(payload) > MAX_TEXT:
            check_texts_of(message)
    except UnreadableError as error:
        raise error.below("goal") from None
    return message


def _no_denial(_member: str, _key: str) -> str:
    return ""


@cache
def _kinds(names: tuple[str, ...]) -> frozenset[str]:
    return frozenset(names)


def condition(request: WatchRequest | UnwatchRequest, keys: Keys) -> Watch | Unwatch:
    """Return the condition of a request.

    Raises:
        UnreadableError: There is no such topic or operator.
    """
    if isinstance(request, UnwatchRequest):
        return Unwatch(request.unwatch)
    comparisons = tuple(_comparison(each, f"when.{number}") for number, each in enumerate(request.when))
    match keys.parse(f"{keys.prefix}/{request.key}"):
        case TopicKey(robot, "events") if robot == WORLD:
            return Watch(request.watch, Topic.EVENTS, comparisons=comparisons)
        case TopicKey(robot, topic) if robot != WORLD and topic in ROBOT_TOPICS:
            return Watch(request.watch, ROBOT_TOPICS[topic], robot, comparisons=comparisons)
        case ActionKey(robot, action, Verb.FEEDBACK):
            return Watch(request.watch, Topic.FEEDBACK, robot, action, comparisons)
    known = ", ".join((f"{WORLD}/events", *(f"ROBOT/{name}" for name in ROBOT_TOPICS), "ROBOT/ACTION/_action/feedback"))
    raise unreadable_at("key", f"no topic {request.key!r} for conditions; there are: {known}", request.key)


def _comparison(parts: list[Any], where: str) -> Comparison:
    pointer, operator, value = parts
    if not isinstance(pointer, str) or (pointer and not pointer.startswith("/")):
        raise unreadable_at(f"{where}.0", "not a JSON pointer, such as '/percentage'", pointer)
    if operator not in _OPERATORS:
        raise unreadable_at(f"{where}.1", f"no operator {operator!r}; there are: {' '.join(_OPERATORS)}", operator)
    if isinstance(value, float) and value - value != 0:
        raise UnreadableError(f"{where}.2: not a finite number")
    path = [_ESCAPED.sub(lambda found: "/" if found[0] == "~1" else "~", part) for part in pointer.split("/")[1:]]
    return Comparison(tuple(path), operator, value)
