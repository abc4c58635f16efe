"""The base of XML trees' action nodes: a goal from input ports, a result to output ports, as in Nav2's BtActionNode."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from functools import cache
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Final

from py_trees.common import Status
from pydantic import ValidationError

from bt_controller.core.action_leaf import ActionLeaf
from bt_controller.core.node import EACH_PERIOD, Node, PortError
from bt_controller.core.ports import DOUBLE, INT, STRING, input_port, output_port
from bt_controller.core.robots import Directory
from hmrsim.actions import registry
from hmrsim.errors import GoalRejected
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.nav_msgs import Goals
from hmrsim.program.users_code import field_errors
from hmrsim.protocol.goal import GoalStatus
from hmrsim_zenoh.errors import ResultExpired

if TYPE_CHECKING:
    from bt_controller.core.ports import Port
    from hmrsim.interfaces.message import Message
    from hmrsim_zenoh.client.goal_handle import GoalHandle

ACTION_INPUTS: Final[Mapping[str, Port]] = MappingProxyType(
    {
        "server_name": input_port(STRING, "Name of the action, if it is not the default", required=False),
        "server_timeout": input_port(DOUBLE, "Ignored: the node does not block", required=False),
    }
)
"""The input ports of every action node."""

ACTION_OUTPUTS: Final[Mapping[str, Port]] = MappingProxyType(
    {
        "error_code_id": output_port(INT, "The result's error code; 0 for none"),
        "error_msg": output_port(STRING, "The error message"),
    }
)
"""The output ports of every Nav2 action node."""


class ActionNode(Node, ActionLeaf[Any, Any, Any]):
    """Sends the goal that its input ports define, and follows it.

    SUCCEEDED is SUCCESS, and so is CANCELED, as in Nav2: another client canceled the goal on purpose. ABORTED and a
    rejection are FAILURE, with the code on ``error_code_id``. When halted, the node cancels its goal. A node that has
    ended and is ticked again without a reset, like a child of a PipelineSequence, sends no goal and returns its last
    status.
    """

    ACTION: ClassVar[str]
    """The name of the action."""

    UNANSWERED: ClassVar[int] = 2
    """The error code if no server answers; Nav2's SEND_GOAL_FAILURE."""

    INPUTS: ClassVar[Mapping[str, Port]] = ACTION_INPUTS
    OUTPUTS: ClassVar[Mapping[str, Port]] = ACTION_OUTPUTS

    FIELDS: ClassVar[Mapping[str, str]] = MappingProxyType({})
    """The fields of the goal and the result whose names differ from their ports' names, by port."""

    CLEARED: ClassVar[tuple[str, ...]] = ()
    """The result's output ports that are cleared if the goal does not succeed."""

    FEEDBACK_OUTPUTS: ClassVar[tuple[str, ...]] = ()
    """The output ports that are written while the goal runs."""

    def __init__(self, name: str, behaviour_class_name: str | None = None) -> None:
        super().__init__(name, self.ACTION, self.goal, behaviour_class_name=behaviour_class_name)

    def setup(self, **kwargs: Any) -> None:
        """Look up the action, by its name in the tree's file, if any.

        Raises:
            NotServed: There is no such robot, or it has no such action.
            PortError: A port's value in the file is invalid, or the name is another action's.
            SimulatorNotFound: No simulator answers.
        """
        if server := self.read("server_name"):
            directory = kwargs.get("directory") or Directory.from_info(kwargs["client"].info())
            self._robot, action = directory.resolve(kwargs["robot"], server)
            if action != self.ACTION:
                raise PortError(f"{self._whose('server_name')}: {server!r} is not a name of {self.ACTION!r}")
        super().setup(**kwargs)

    def goal(self) -> Message | Mapping[str, Any] | None:
        """Return the goal of the input ports, in plain values if `PLAIN`; None to fail, with a feedback message."""
        return self.goal_with()

    def goal_with(self, **fields: Any) -> Message:
        """Return a goal with these fields; other fields come from the input ports of the same names.

        A field keeps the message's default if its port has no value. Ports hold durations in seconds.
        """
        message: Any = registry()[self.ACTION].goal
        for port, field, of in _goal_ports(type(self), message):
            if field not in fields and (value := self.read(port)) is not None:
                fields[field] = value if of is None else of(value)
        goal: Message = message(**fields)
        return goal

    def write_result(self, result: Any) -> None:
        """Write the result of a succeeded goal to the output ports."""
        if ports := _result_ports(type(self), result.__class__):
            self._write_fields(result, ports)

    def write_feedback(self, feedback: Any) -> None:
        """Write the latest feedback to the output ports."""

    @property
    def wants_feedback(self) -> bool:
        """True if a node of the tree reads the feedback that this node writes."""
        return bool(self.FEEDBACK_OUTPUTS) and any(self.is_read(port) for port in self.FEEDBACK_OUTPUTS)

    def clear_result(self) -> None:
        """Write empty values to the output ports: the goal did not succeed, or the node was halted."""
        if self.CLEARED:
            self._write_fields(registry()[self.ACTION].result(), self.CLEARED)

    def _write_fields(self, result: Any, ports: Iterable[str]) -> None:
        for port in ports:
            value = getattr(result, self.FIELDS.get(port, port))
            self.write(
                port, value.to_seconds() if isinstance(value, Duration) and self.OUTPUTS[port].kind is DOUBLE else value
            )

    def code_of(self, result: Any) -> tuple[int, str]:
        """Return the code and the message of a result."""
        return result.error_code, result.error_msg

    def _next_goal(self) -> Message | Mapping[str, Any] | None:
        try:
            return super()._next_goal()
        except ValidationError as error:
            goal = f"{self.located}: the goal of {self.ACTION!r}"
            raise PortError("\n".join(f"{goal}: {message}" for message in field_errors(error))) from None

    def should_replace_goal(self) -> bool:
        """Return whether to replace the active goal by the one that `goal` returns now."""
        return False

    def next_tick_time(self) -> float:
        """Return infinity unless the node is idle: it needs no polling, as events of its goal wake it.

        The ports that `should_replace_goal` reads need no polling either: the blackboard changes only in ticks.
        """
        return EACH_PERIOD if self.status is Status.INVALID else math.inf

    def initialise(self) -> None:
        """Send the goal, if the node is idle."""
        if self.status is Status.INVALID:
            super().initialise()

    def update(self) -> Status:
        """Return the status of the goal, after replacing it if necessary."""
        if self.status is Status.RUNNING and self.should_replace_goal():
            # The robot preempts the old goal when it accepts the new one, as Nav2's servers do.
            super().initialise()
        if self._handle is None:
            self._write_error(self.UNANSWERED, self.feedback_message)
            self.clear_result()
            # Cancel the goal that was to be replaced.
            self.cancel()
        status = super().update()
        if status is Status.RUNNING and self._handle is not None and self._handle.feedback is not None:
            self.write_feedback(self._handle.feedback)
        return status

    def ended(self, handle: GoalHandle[Any, Any]) -> Status:
        """Write the code and the result to the output ports, and return the status."""
        if (error := handle.error) is not None:
            self._write_error(self._code_of_error(error) or self.UNANSWERED, str(error))
            self.clear_result()
            self.cancel()
            return super().ended(handle)
        canceled, result = handle.status is GoalStatus.CANCELED, handle.result_message
        self._write_error(*((0, "") if canceled else self.code_of(result)))
        status = super().ended(handle)
        if status is Status.SUCCESS:
            self.write_result(result)
        else:
            self.clear_result()
        return Status.SUCCESS if canceled else status

    def terminate(self, new_status: Status) -> None:
        """Cancel the goal and clear the outputs if the node is halted."""
        if new_status is Status.INVALID and self.status is Status.RUNNING:
            self.clear_result()
        super().terminate(new_status)

    def _code_of_error(self, error: Exception) -> int:
        """Return the error code of a goal without a result; 0 if there is none."""
        if isinstance(error, ResultExpired) and self.action is not None:
            return self.action.codes.unknown
        return getattr(error, "error_code", 0) if isinstance(error, GoalRejected) else 0

    def _write_error(self, code: int, message: str) -> None:
        """Write an error to the output ports, if the node has them; code 0 for none."""
        if "error_code_id" in self.OUTPUTS:
            self.write("error_code_id", code)
            self.write("error_msg", message)


@cache
def _goal_ports(node: type[ActionNode], message: Any) -> tuple[tuple[str, str, Callable[[Any], object] | None], ...]:
    """Return the input ports of a node that are fields of its goal: port, field, and the conversion of the value."""
    fields = ((port, node.FIELDS.get(port, port)) for port in node.INPUTS)
    return tuple(
        (port, field, _CONVERSIONS.get(message.model_fields[field].annotation))
        for port, field in fields
        if field in message.model_fields
    )


@cache
def _result_ports(node: type[ActionNode], message: Any) -> tuple[str, ...]:
    """Return the output ports of a node that are fields of its result, except those of the error."""
    ports = (port for port in node.OUTPUTS if port not in ACTION_OUTPUTS)
    return tuple(port for port in ports if node.FIELDS.get(port, port) in message.model_fields)


_CONVERSIONS: Final[Mapping[object, Callable[[Any], object]]] = MappingProxyType(
    {Duration: Duration.from_seconds, Goals: lambda poses: Goals(goals=poses)}
)
"""The conversions of ports' values to the types of fields in goals."""
