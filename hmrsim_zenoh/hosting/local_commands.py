"""Commands of clients in the simulator's process: objects, which are checked."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from hmrsim.actions import registry as all_actions
from hmrsim.interfaces.message import complete
from hmrsim.protocol.commands import Advance, CallService, CancelGoal, GetResult, SendGoal, Unreadable
from hmrsim.protocol.time import Join, Leave, ReadTime
from hmrsim_zenoh.client.connection import Watched
from hmrsim_zenoh.errors import RequestError
from hmrsim_zenoh.server.decode_time import WatchRequest, condition, goal_id_in, read_goal
from hmrsim_zenoh.wire.envelopes import UnreadableError, check_texts_of, plain, unreadable

if TYPE_CHECKING:
    from hmrsim_zenoh.client.local_connection import Pending
    from hmrsim_zenoh.wire.keys import Keys


ClientCommand = SendGoal | CancelGoal | GetResult | CallService | Join | Advance | Leave | ReadTime
"""The commands that clients in this process send as objects; other requests go by keys."""


def checked(
    command: ClientCommand,
    pending: Pending | None,
    keys: Keys,
    cancel: str = "goal_info.goal_id",
    result: str = "goal_id",
) -> ClientCommand:
    """Return a command with resolved names and validated messages.

    Args:
        command: The command.
        pending: Receives its answer; None for a command of an advance.
        keys: How keys are spelled, with the aliases of actions.
        cancel: The field that has the goal's id in a cancel on the wire, for errors.
        result: The same for the request of a result.

    Raises:
        UnreadableError: It can't be understood.
    """
    match command:
        case Advance(participant, epoch, until, wake, report, commands):
            queued = tuple([_queued(each, keys) for each in commands])
            return Advance(participant, epoch, until, wake, report, queued, pending)
        case SendGoal():
            return _goal(command, pending, keys)
        case CancelGoal():
            return _named(command, pending, keys, cancel)
        case GetResult():
            return _named(command, pending, keys, result)
        case CallService(request=request):
            check_texts_of(request)
    return command if pending is None else command._replace(reply_to=pending)


def _queued(command: Any, keys: Keys) -> Any:
    """Return a command of an advance, or why it can't be understood, which is its answer."""
    try:
        if isinstance(command, SendGoal):
            return _goal(command, None, keys)
        if not isinstance(command, Watched):
            return checked(command, None, keys, "cancel", "result")
        name, wanted = command
        asked = {"watch": name, "key": wanted.key, "when": [list(each) for each in wanted.when]}
        return condition(plain(WatchRequest).validate_python(asked), keys)
    except ValidationError as error:
        return Unreadable(error_of(unreadable(error)))
    except UnreadableError as error:
        return Unreadable(error_of(error))


def _named(command: CancelGoal | GetResult, pending: Pending | None, keys: Keys, field: str) -> CancelGoal | GetResult:
    goal_id = goal_id_in(field, command.goal_id)
    robot, action = keys.resolve(command.robot, command.action)
    return command._replace(robot=robot, action=action, goal_id=goal_id, reply_to=pending)


def _goal(command: SendGoal, pending: Pending | None, keys: Keys) -> SendGoal:
    robot, name = command.robot, command.action
    if keys.aliases:
        robot, name = keys.resolve(robot, name)
    action = all_actions().get(name)
    # The simulation rejects an action that the robot does not serve; the goal's type is unknown here.
    goal: Any = command.goal
    if action is None:
        goal = None
    elif isinstance(goal, action.goal):
        try:
            check_texts_of(goal)
        except UnreadableError as error:
            raise error.below("goal") from None
        # As a goal that came over the network.
        complete(goal)
    else:
        goal = read_goal(action.goal, goal)
    if goal is command.goal and pending is None and (robot, name) == (command.robot, command.action):
        return command
    return SendGoal(robot, name, goal, command.goal_id, pending)


def error_of(error: UnreadableError) -> RequestError:
    """Return the answer to a command that can't be understood."""
    return RequestError(str(error), error.details)
