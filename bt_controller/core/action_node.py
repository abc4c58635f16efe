"""The actions of XML trees: a goal made of ports, and a result that goes to ports, as Nav2's BtActionNode has it."""

from __future__ import annotations

import math
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Final

from py_trees.common import Status

from bt_controller.core.action_leaf import ActionLeaf
from bt_controller.core.node import EACH_PERIOD, Node, PortError
from bt_controller.core.ports import DOUBLE, INT, STRING, input_port, output_port
from bt_controller.world.directory import Directory
from hmrsim.errors import GoalRejected
from hmrsim.protocol.goal import GoalStatus
from hmrsim_zenoh.errors import ResultExpired

if TYPE_CHECKING:
    from collections.abc import Mapping

    from bt_controller.core.ports import Port
    from hmrsim.interfaces.message import Message
    from hmrsim_zenoh.client.goal_handle import GoalHandle

ACTION_INPUTS: Final[Mapping[str, Port]] = MappingProxyType(
    {
        "server_name": input_port(STRING, "Name of the action, if it is another than usual", required=False),
        "server_timeout": input_port(DOUBLE, "Milliseconds; read and not needed: nothing waits here", required=False),
    }
)
"""What every action takes."""

ACTION_OUTPUTS: Final[Mapping[str, Port]] = MappingProxyType(
    {
        "error_code_id": output_port(INT, "The result's error code; 0 for none"),
        "error_msg": output_port(STRING, "What is wrong"),
    }
)
"""What every action of Nav2's gives."""


class ActionNode(Node, ActionLeaf[Any, Any, Any]):
    """Sends the goal that its ports make, and follows it.

    SUCCEEDED and CANCELED are SUCCESS, as in Nav2: whoever else cancels a goal knows what for. ABORTED and a
    rejection are FAILURE, with the code on ``error_code_id``. Halted, the node cancels its goal. One that has ended
    and is ticked again without having been reset, as children of a PipelineSequence are, sends nothing, and ends as
    it did.
    """

    ACTION: ClassVar[str]
    """The name of the action."""

    UNANSWERED: ClassVar[int] = 2
    """The code where no server answers; Nav2's SEND_GOAL_FAILURE."""

    INPUTS: ClassVar[Mapping[str, Port]] = ACTION_INPUTS
    OUTPUTS: ClassVar[Mapping[str, Port]] = ACTION_OUTPUTS

    def __init__(self, name: str, behaviour_class_name: str | None = None) -> None:
        super().__init__(name, self.ACTION, self.goal, behaviour_class_name=behaviour_class_name)

    def setup(self, **kwargs: Any) -> None:
        """Look the action up, by the name that the file gives it, if any.

        Args:
            **kwargs: As those of `ActionLeaf` and of all nodes.

        Raises:
            NotServed: There is no such robot, or it has no such action.
            PortError: What the file says is not what a port takes; or the name is another action's.
            NobodyThere: No simulator answers.
        """
        if server := self.read("server_name"):
            directory = kwargs.get("directory") or Directory.from_info(kwargs["client"].info())
            self._robot, action = directory.resolve(kwargs["robot"], server)
            if action != self.ACTION:
                raise PortError(f"{self._whose('server_name')}: {server!r} is not a name of {self.ACTION!r}")
        super().setup(**kwargs)

    def goal(self) -> Message | None:
        """Return the goal as the ports say it; None to fail without one, with a feedback message of why."""
        raise NotImplementedError

    def take(self, result: Any) -> None:
        """Put a result of SUCCEEDED on the output ports."""

    def take_nothing(self) -> None:
        """Put on the output ports what stands for no result: the goal ended otherwise, or the node was halted."""

    def code_of(self, result: Any) -> tuple[int, str]:
        """Return the code and the message of a result."""
        return result.error_code, result.error_msg

    def wants_other_goal(self) -> bool:
        """Return whether the goal that is under way shall be replaced by what `goal` makes now."""
        return False

    def next_tick_time(self) -> float:
        """Return that a running goal tells by itself, and that one which has ended stays as it is.

        What a port leads to changes in ticks only, so whatever `wants_other_goal` looks at there needs no look of
        its own.
        """
        return EACH_PERIOD if self.status is Status.INVALID else math.inf

    def initialise(self) -> None:
        """Send the goal, if the node is idle."""
        if self.status is Status.INVALID:
            super().initialise()

    def update(self) -> Status:
        """Return what has become of the goal, after replacing it if that is due."""
        if self.status is Status.RUNNING and self.wants_other_goal():
            # The robot drops the old one when it accepts the new one, as Nav2's servers do.
            super().initialise()
        if self._handle is None:
            self._blame(self.UNANSWERED, self.feedback_message)
            self.take_nothing()
            # One that was to be replaced.
            self.cancel()
        return super().update()

    def ended(self, handle: GoalHandle[Any, Any]) -> Status:
        """Put the code and the result where the ports lead, and return what they mean."""
        if handle.error is not None:
            self._blame(self._code_of_error(handle.error) or self.UNANSWERED, str(handle.error))
            self.take_nothing()
            self.cancel()
            return super().ended(handle)
        if handle.status is GoalStatus.CANCELED:
            self._blame(0, "")
        else:
            self._blame(*self.code_of(handle.result_message))
        if handle.status is GoalStatus.SUCCEEDED:
            self.take(handle.result_message)
        else:
            self.take_nothing()
        status = super().ended(handle)
        return Status.SUCCESS if handle.status is GoalStatus.CANCELED else status

    def terminate(self, new_status: Status) -> None:
        """Cancel the goal if the node is halted; what it has given before is no longer true then."""
        if new_status is Status.INVALID and self.status is Status.RUNNING:
            self.take_nothing()
        super().terminate(new_status)

    def _code_of_error(self, error: Exception) -> int:
        """Return the code of a goal that has no result; 0 if nobody gave it any."""
        if isinstance(error, ResultExpired) and self.action is not None:
            return self.action.codes.unknown
        return getattr(error, "error_code", 0) if isinstance(error, GoalRejected) else 0

    def _blame(self, code: int, message: str) -> None:
        if "error_code_id" in self.OUTPUTS:
            self.write("error_code_id", code)
            self.write("error_msg", message)
