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


class LocalCommands:
    """Reads the commands of clients in this process.

    Args:
        keys: How keys are spelled, with the aliases of actions.
    """

    def __init__(self, keys: Keys) -> None:
        self._keys = keys
        self._actions = all_actions()

    def checked(
        self,
        command: ClientCommand,
        pending: Pending | None,
        cancel: str = "goal_info.goal_id",
        result: str = "goal_id",
    ) -> ClientCommand:
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
                return self.checked(command, None, "cancel", "result")
            name, wanted = command
            asked = {"watch": name, "key": wanted.key, "when": [list(each) for each in wanted.when]}
            return condition(plain(WatchRequest).validate_python(asked), self._keys)
        except ValidationError as error:
            return Unreadable(error_of(unreadable(error)))
        except UnreadableError as error:
            return Unreadable(error_of(error))

    def _named(self, command: CancelGoal | GetResult, pending: Pending | None, field: str) -> CancelGoal | GetResult:
        goal_id = goal_id_in(field, command.goal_id)
        robot, action = self._keys.resolve(command.robot, command.action)
        return command._replace(robot=robot, action=action, goal_id=goal_id, reply_to=pending)

    def _goal(self, command: SendGoal, pending: Pending | None) -> SendGoal:
        robot, name = command.robot, command.action
        if self._keys.aliases:
            robot, name = self._keys.resolve(robot, name)
        action = self._actions.get(name)
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
