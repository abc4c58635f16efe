"""Commands of clients in the simulator's process: they go to its inbox as objects; the answers come back as objects."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from hmrsim.actions import registry as all_actions
from hmrsim.errors import SimulationStopped
from hmrsim.interfaces.message import Message, complete
from hmrsim.protocol.commands import Advance, CallService, CancelGoal, GetResult, SendGoal, Unreadable
from hmrsim.protocol.goal import Refused, parse_goal_id
from hmrsim.protocol.outputs import Answered, Granted, RosterChanged
from hmrsim.protocol.sinks import SelectiveSink
from hmrsim.protocol.time import Join, Leave, ReadTime
from hmrsim_zenoh.client.conditions import Watched
from hmrsim_zenoh.client.connection import ReadInfo
from hmrsim_zenoh.client.local_connection import Pending
from hmrsim_zenoh.errors import RequestError
from hmrsim_zenoh.server.decode_time import WatchRequest, condition, read_goal
from hmrsim_zenoh.server.replies import after_the_end, finish
from hmrsim_zenoh.wire.envelopes import UnreadableError, check_texts_of, plain, unreadable, unreadable_at

if TYPE_CHECKING:
    from hmrsim.protocol.commands import AnyCommand
    from hmrsim_zenoh.client.exchange import Delivery
    from hmrsim_zenoh.server.inbox import QueryInbox
    from hmrsim_zenoh.server.server import Server
    from hmrsim_zenoh.server.world_info import Description
    from hmrsim_zenoh.wire.keys import Keys


ClientCommand = SendGoal | CancelGoal | GetResult | CallService | Join | Advance | Leave | ReadTime
"""The commands that clients in this process send as objects; other requests go by keys."""


class LocalCommands(SelectiveSink):
    """Receives the commands of all clients of a process; a sink of the simulation, which emits the answers.

    Args:
        delivery: Delivers the answers while the simulation does not run.
        inbox: The inbox of the simulation.
        description: The description of the simulation.
        open_keys: Begins to serve keys, which ends in a call of `serve_keys`.

    Attributes:
        keys: How keys are spelled, with the aliases of actions.
    """

    def __init__(
        self,
        delivery: Delivery,
        inbox: QueryInbox,
        keys: Keys,
        description: Description,
        open_keys: Callable[[], object],
    ) -> None:
        self.keys = keys
        self._delivery = delivery
        self._inbox = inbox
        self._losses = inbox.losses
        self._description = description
        self._open_keys = open_keys
        self._actions = all_actions()
        self._server: Server | None = None
        self._left = False

    def serve_keys(self, server: Server) -> None:
        """Take notice of the server of the keys of the same simulation."""
        self._server = server

    def leave(self) -> None:
        """Leave further commands without an answer."""
        self._left = True

    def finish(self, submit: Callable[[AnyCommand], None], answer: Callable[[Any, Any], None]) -> None:
        """Answer what still waits when the simulation has ended; see `Server.finish`."""
        if self._server is None:
            finish(self._inbox, submit, answer)
        else:
            self._server.finish(submit, answer)

    def send(self, command: ClientCommand | ReadInfo, pending: Pending) -> None:
        """Send a command; *pending* takes its answer, once, while the simulation does not run.

        It is None if the answer is lost, and a `RequestError` if the command can't be served.
        """
        losses, delivery = self._losses, self._delivery
        # Requests that change nothing are exempt, as a client simply repeats them.
        disturbed = losses.active and not isinstance(command, (ReadInfo, ReadTime))
        pending.may_be_lost = disturbed and losses.watching
        try:
            if isinstance(command, ReadInfo):
                delivery.deliver(
                    pending.take, self._refusal(command) if self._inbox.closed else self._description.info_values()
                )
            else:
                command = self._checked(command, pending, "goal_info.goal_id", "goal_id")
                if self._server is None and self._description.plans_externally:
                    self._open_keys()
                if self._server is not None:
                    for each in self._server.before(command):
                        self._inbox.put(each)
                self._inbox.put(command)
                if disturbed and losses.comes_twice():
                    self._inbox.put(command._replace(reply_to=None))
        except UnreadableError as error:
            delivery.deliver(pending.take, _error(error))
        except SimulationStopped:
            # Another thread may have ended the run just now.
            delivery.deliver(pending.take, self._refusal(command))
        delivery.settle(resume=True)

    def handler_for(self, kind: type) -> Callable[[Any], object] | None:
        """Return the function that processes outputs of a type; None to ignore them."""
        return self._answer if kind is Answered else self._follow_roster if kind is RosterChanged else None

    def _answer(self, answered: Answered) -> None:
        pending = answered.reply_to
        if isinstance(pending, Pending):
            answer = answered.answer
            if type(answer) is Refused or (type(answer) is Granted and Refused in map(type, answer.accepted)):
                answer = _for_client(answer)
            lost = pending.may_be_lost and self._losses.lost()
            self._delivery.deliver(pending.take, None if lost else answer)

    def _refusal(self, command: ClientCommand | ReadInfo) -> Any:
        """Return the answer to a command after the end of the run; None once the host has stopped."""
        return None if self._left else _for_client(after_the_end(command))

    def _follow_roster(self, _changed: RosterChanged) -> None:
        self._description.forget()
        self.keys = replace(self.keys, aliases=self._description.aliases)

    def _checked(self, command: ClientCommand, pending: Pending | None, cancel: str, result: str) -> ClientCommand:
        """Return a command with resolved names and validated messages.

        *pending* receives its answer; *cancel* and *result* are the fields that have the goal's id on the wire, for
        errors.

        Raises:
            UnreadableError: It can't be understood.
        """
        match command:
            case Advance(participant, epoch, until, wake, report, commands):
                return Advance(participant, epoch, until, wake, report, tuple(map(self._queued, commands)), pending)
            case SendGoal():
                return self._goal(command, pending)
            case CancelGoal():
                return self._named(command, pending, cancel)
            case GetResult():
                return self._named(command, pending, result)
            case CallService(request=request):
                check_texts_of(request)
        return command if pending is None else command._replace(reply_to=pending)

    def _queued(self, command: Any) -> Any:
        """Return a command of an advance, or why it can't be understood, which is its answer."""
        try:
            if isinstance(command, SendGoal):
                return self._goal(command, None)
            if not isinstance(command, Watched):
                return self._checked(command, None, "cancel", "result")
            name, wanted = command
            asked = {"watch": name, "key": wanted.key, "when": [list(each) for each in wanted.when]}
            return condition(plain(WatchRequest).validate_python(asked), self.keys)
        except ValidationError as error:
            return Unreadable(_error(unreadable(error)))
        except UnreadableError as error:
            return Unreadable(_error(error))

    def _named(self, command: CancelGoal | GetResult, pending: Pending | None, field: str) -> CancelGoal | GetResult:
        try:
            goal_id = parse_goal_id(command.goal_id)
        except ValueError as error:
            raise unreadable_at(field, str(error), command.goal_id) from None
        robot, action = self.keys.resolve(command.robot, command.action)
        return command._replace(robot=robot, action=action, goal_id=goal_id, reply_to=pending)

    def _goal(self, command: SendGoal, pending: Pending | None) -> SendGoal:
        robot, name = command.robot, command.action
        if self.keys.aliases:
            robot, name = self.keys.resolve(robot, name)
        action = self._actions.get(name)
        # The simulation rejects an action that the robot does not serve; the goal's type is unknown here.
        goal: Any = command.goal
        if action is None:
            goal = None
        elif isinstance(goal, action.goal):
            _complete(goal)
        else:
            goal = read_goal(action.goal, goal)
        if goal is command.goal and pending is None and (robot, name) == (command.robot, command.action):
            return command
        return SendGoal(robot, name, goal, command.goal_id, pending)


def _complete(goal: Message) -> None:
    """Check and complete a goal as over the network."""
    try:
        check_texts_of(goal)
    except UnreadableError as error:
        raise error.below("goal") from None
    complete(goal)


def _error(error: UnreadableError) -> RequestError:
    return RequestError(str(error), error.details)


def _for_client(answer: Any) -> Any:
    """Return an answer as the client receives it, with refusals turned into errors."""
    match answer:
        case Refused(field, value, text):
            return RequestError(text, [{"field": field, "message": text, "value": value}])
        case Granted(accepted=accepted):
            return answer._replace(accepted=tuple(map(_for_client, accepted)))
    return answer
