"""The actions of XML trees: a goal made of ports, and a result that goes to ports, as Nav2's BtActionNode has it."""

from __future__ import annotations

import math
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Final

from py_trees.common import Status

from bt_controller.action_leaf import ActionLeaf
from bt_controller.node import EACH_PERIOD, Node
from bt_controller.ports import DOUBLE, INT, STRING, gives, wants
from hmrsim.errors import GoalRejected
from hmrsim.goal import GoalStatus

if TYPE_CHECKING:
    from collections.abc import Mapping

    from bt_controller.ports import Port
    from hmrsim.interfaces.message import Message
    from hmrsim_zenoh.goal_handle import GoalHandle

ACTION_INPUTS: Final[Mapping[str, Port]] = MappingProxyType(
    {
        "server_name": wants(STRING, "Name of the action, if it is another than usual", required=False),
        "server_timeout": wants(DOUBLE, "Milliseconds; read and not needed: nothing waits here", required=False),
    }
)
"""What every action takes."""

ACTION_OUTPUTS: Final[Mapping[str, Port]] = MappingProxyType(
    {
        "error_code_id": gives(INT, "The result's error code; 0 for none"),
        "error_msg": gives(STRING, "What is wrong"),
    }
)
"""What every action of Nav2's gives."""

_SEND_GOAL_FAILURE: Final = 2
"""Nav2's code where no server answers."""


class ActionNode(Node, ActionLeaf[Any, Any, Any]):
    """Sends the goal that its ports make, and follows it.

    SUCCEEDED and CANCELED are SUCCESS, as in Nav2: whoever else cancels a goal knows what for. ABORTED and a
    rejection are FAILURE, with the code on ``error_code_id``. Halted, the node cancels its goal.
    """

    ACTION: ClassVar[str]
    """The name of the action."""

    INPUTS: ClassVar[Mapping[str, Port]] = ACTION_INPUTS
    OUTPUTS: ClassVar[Mapping[str, Port]] = ACTION_OUTPUTS

    def __init__(self, name: str, behaviour_class_name: str | None = None) -> None:
        super().__init__(name, self.ACTION, self.goal, behaviour_class_name=behaviour_class_name)

    def goal(self) -> Message | None:
        """Return the goal as the ports say it; None to fail without one, with a feedback message of why."""
        raise NotImplementedError

    def take(self, result: Any) -> None:
        """Put a result of SUCCEEDED on the output ports."""

    def wants_other_goal(self) -> bool:
        """Return whether the goal that is under way shall be replaced by what `goal` makes now."""
        return False

    def next_look(self) -> float:
        """Return that a running goal tells by itself; one that looks at its ports meanwhile has to say more."""
        if self.status is not Status.RUNNING:
            return EACH_PERIOD
        return math.inf if type(self).wants_other_goal is ActionNode.wants_other_goal else EACH_PERIOD

    def update(self) -> Status:
        """Return what has become of the goal, after replacing it if that is due."""
        if self.status is Status.RUNNING and self.wants_other_goal():
            # The robot drops the old one when it accepts the new one, as Nav2's servers do.
            self.initialise()
        return super().update()

    def ended(self, handle: GoalHandle[Any, Any]) -> Status:
        """Put the code and the result where the ports lead, and return what they mean."""
        if handle.error is not None:
            code = getattr(handle.error, "error_code", 0) if isinstance(handle.error, GoalRejected) else 0
            self._blame(code or _SEND_GOAL_FAILURE, str(handle.error))
            self.cancel()
            return super().ended(handle)
        result = handle.result_message
        if handle.status in (GoalStatus.SUCCEEDED, GoalStatus.CANCELED):
            self._blame(0, "")
            if handle.status is GoalStatus.SUCCEEDED:
                self.take(result)
                return super().ended(handle)
            self.feedback_message = "canceled"
            return Status.SUCCESS
        self._blame(getattr(result, "error_code", 0), getattr(result, "error_msg", ""))
        return super().ended(handle)

    def _blame(self, code: int, message: str) -> None:
        if "error_code_id" in self.OUTPUTS:
            self.write("error_code_id", code)
            self.write("error_msg", message)
