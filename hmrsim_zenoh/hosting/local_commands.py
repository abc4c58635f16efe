"""Commands of clients in the simulator's own process: they go to its inbox as they are, and answers come back so."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from hmrsim.actions import registry as all_actions
from hmrsim.errors import SimulationStopped
from hmrsim.interfaces.message import Message, complete
from hmrsim.protocol.answers import Refused
from hmrsim.protocol.commands import Advance, CallService, CancelGoal, GetResult, SendGoal, Unreadable
from hmrsim.protocol.goal import parse_goal_id
from hmrsim.protocol.outputs import Answered, Granted
from hmrsim.protocol.sinks import SelectiveSink
from hmrsim.protocol.time import Join, Leave, ReadTime
from hmrsim_zenoh.client.conditions import Watched
from hmrsim_zenoh.client.connection import ReadInfo
from hmrsim_zenoh.errors import RequestError
from hmrsim_zenoh.loopback.exchange import Kind
from hmrsim_zenoh.server.decode_conditions import WatchRequest, condition
from hmrsim_zenoh.server.decode_time import read_goal
from hmrsim_zenoh.wire.envelopes import UnreadableError, check_texts_of, plain, unreadable, unreadable_at

if TYPE_CHECKING:
    from hmrsim.protocol.topics import Topic
    from hmrsim_zenoh.loopback.exchange import Exchange
    from hmrsim_zenoh.server.server import Server


ClientCommand = SendGoal | CancelGoal | GetResult | CallService | Join | Advance | Leave | ReadTime
"""The commands that clients in this process send as objects; other requests go by keys."""


class _Asked:
    """A command that awaits its answer, which may get lost."""

    __slots__ = ("loses", "then")

    def __init__(self, then: Callable[[Any], object], loses: Callable[[], bool] | None) -> None:
        self.then = then
        self.loses = loses


class LocalCommands(SelectiveSink):
    """Takes the commands of all clients of a process; a sink of the simulation, for the answers.

    Args:
        exchange: Delivers the answers while the simulation does not run.
        server: The server of the same simulation.
    """

    def __init__(self, exchange: Exchange, server: Server) -> None:
        self._exchange = exchange
        self._server = server
        self._inbox = server.inbox
        self._losses = server.inbox.losses
        self._actions = all_actions()

    def send(self, command: ClientCommand | ReadInfo, then: Callable[[Any], object]) -> None:
        """Send a command; *then* receives its answer, once, while the simulation does not run.

        It is None if the answer is lost, and a `RequestError` if the command can't be served.
        """
        if isinstance(command, ReadInfo):
            self._exchange.deliver(then, self._refusal(command) if self._inbox.closed else self._server.info())
            self._exchange.settle()
            return
        losses = self._losses
        # Readings are left alone, which are repeated without a thought.
        disturbed = losses.active and not isinstance(command, ReadTime)
        asked = _Asked(then, losses.lost if disturbed and losses.watching else None)
        try:
            command = self._checked(command, asked, "goal_info.goal_id", "goal_id")
        except UnreadableError as error:
            self._exchange.deliver(then, RequestError(str(error), error.details))
        else:
            self._put(command, then, repeated=disturbed and losses.comes_twice())
        self._exchange.settle()

    def wants(self, _topic: Topic) -> bool:
        """Return False: answers are sent regardless of topics."""
        return False

    def handler_for(self, kind: type) -> Callable[[Any], object] | None:
        """Return the function that processes outputs of a type; None to ignore them."""
        return self._answer if kind is Answered else None

    def _answer(self, answered: Answered) -> None:
        asked = answered.reply_to
        if type(asked) is _Asked:
            lost = asked.loses is not None and asked.loses()
            self._exchange.deliver(asked.then, None if lost else _as_told(answered.answer))

    def _put(self, command: ClientCommand, then: Callable[[Any], object], *, repeated: bool) -> None:
        try:
            for each in self._server.before(command):
                self._inbox.put(each)
            self._inbox.put(command)
            if repeated:
                self._inbox.put(command._replace(reply_to=None))
        except SimulationStopped:
            self._exchange.deliver(then, self._refusal(command))

    def _refusal(self, command: ClientCommand | ReadInfo) -> Any:
        """Return the answer to a command after the end of the run; None once the server is gone."""
        served = self._exchange.matching(Kind.QUERYABLE, self._server.keys.wakeup_key())
        return _as_told(self._server.refusal_of(command)) if served else None

    def _checked(self, command: ClientCommand, asked: _Asked | None, cancel: str, result: str) -> ClientCommand:
        """Return a command with resolved names and validated messages.

        *asked* receives its answer; *cancel* and *result* are the fields that have the goal's id on the wire, for
        errors.

        Raises:
            UnreadableError: It can't be understood.
        """
        match command:
            case Advance(participant, epoch, until, wake, report, commands):
                return Advance(participant, epoch, until, wake, report, tuple(map(self._given, commands)), asked)
            case SendGoal():
                return self._goal(command, asked)
            case CancelGoal():
                return self._named(command, asked, cancel)
            case GetResult():
                return self._named(command, asked, result)
            case CallService(request=request):
                check_texts_of(request)
        return command if asked is None else command._replace(reply_to=asked)

    def _given(self, command: Any) -> Any:
        """Return a command of an advance, or why it can't be understood, which is its answer."""
        try:
            if not isinstance(command, Watched):
                return self._checked(command, None, "cancel", "result")
            name, wanted = command
            asked = {"watch": name, "key": wanted.key, "when": [list(each) for each in wanted.when]}
            return condition(plain(WatchRequest).validate_python(asked), self._server.keys)
        except ValidationError as error:
            return Unreadable(_error(unreadable(error)))
        except UnreadableError as error:
            return Unreadable(_error(error))

    def _named(self, command: CancelGoal | GetResult, asked: _Asked | None, field: str) -> CancelGoal | GetResult:
        try:
            goal_id = parse_goal_id(command.goal_id)
        except ValueError as error:
            raise unreadable_at(field, str(error), command.goal_id) from None
        robot, action = self._server.keys.resolve(command.robot, command.action)
        return command._replace(robot=robot, action=action, goal_id=goal_id, reply_to=asked)

    def _goal(self, command: SendGoal, asked: _Asked | None) -> SendGoal:
        robot, name = self._server.keys.resolve(command.robot, command.action)
        action = self._actions.get(name)
        # The simulation rejects an action that the robot does not serve; the goal's type is unknown here.
        goal = None if action is None else _message(action.goal, command.goal)
        return SendGoal(robot, name, goal, command.goal_id, asked)


def _message(kind: type[Message], goal: Any) -> Message:
    """Return a goal as a message, with the checks that it has over the network."""
    if not isinstance(goal, kind):
        return read_goal(kind, goal)
    try:
        check_texts_of(goal)
    except UnreadableError as error:
        raise error.below("goal") from None
    complete(goal)
    return goal


def _error(error: UnreadableError) -> RequestError:
    return RequestError(str(error), error.details)


def _as_told(answer: Any) -> Any:
    """Return an answer as the client receives it, with refusals turned into errors."""
    match answer:
        case Refused(field, value, text):
            return RequestError(text, [{"field": field, "message": text, "value": value}])
        case Granted(accepted=accepted) if any(type(each) is Refused for each in accepted):
            return answer._replace(accepted=tuple(map(_as_told, accepted)))
    return answer
