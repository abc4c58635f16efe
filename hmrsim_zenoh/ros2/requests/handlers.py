"""Requests of ROS clients, and their handlers: requests to commands, and answers to ROS messages.

A service may have several layouts, as types differ between distributions; the key of a request selects one.
"""

from __future__ import annotations

import logging
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

import zenoh

from hmrsim.goals.fault_effects import no_connection
from hmrsim.interfaces.action_msgs import CancelGoal as CancelGoalService
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS, values_of
from hmrsim.interfaces.rcl_interfaces import SetParametersResult
from hmrsim.interfaces.simulation_interfaces import Result
from hmrsim.protocol.commands import CallService, CancelGoal, GetResult, SendGoal
from hmrsim.protocol.goal import WORLD, Refused, Verdict
from hmrsim_zenoh.ros2.codec.layout import CdrError
from hmrsim_zenoh.ros2.keys import NO_HASH
from hmrsim_zenoh.ros2.names import WORLD_NODE, node_of

if TYPE_CHECKING:
    from hmrsim.actions import AnyAction
    from hmrsim.interfaces.message import Message
    from hmrsim.protocol.commands import AnyCommand
    from hmrsim.protocol.goal import CancelResponse, GoalResponse, ResultResponse
    from hmrsim.services import Service
    from hmrsim.simulation.simulator import Simulator
    from hmrsim_zenoh.ros2.codec.types import ServiceType
    from hmrsim_zenoh.ros2.keys import Address, Node
    from hmrsim_zenoh.ros2.wires import Attachment, Wire

_log = logging.getLogger(__name__)

_REJECTED: Final = CancelGoalService.Response.ERROR_REJECTED
_UNKNOWN: Final = CancelGoalService.Response.ERROR_UNKNOWN_GOAL_ID
_REJECT_EARLY: Final = frozenset({"lyrical", "rolling"})
"""The distributions whose Nav2 rejects some goals that earlier ones accept and abort."""
_STAMP: Final = 1
"""The stamp of rejected goals in nanoseconds: ROS reads 0 as "unset"."""


class Layouts:
    """The layouts of one service.

    Attributes:
        types: One for each distribution, oldest first.
    """

    def __init__(self, types: tuple[ServiceType, ...], distros: tuple[str, ...] = ()) -> None:
        self.types = types
        self._by_key = {(one.dds_name, one.hash): one for one in types}
        self._aborting = {one.hash for one, distro in zip(types, distros, strict=False) if distro not in _REJECT_EARLY}

    def of(self, address: Address) -> ServiceType | None:
        """Return the layout that a key names, or the first if it names none; None if it names an unknown one."""
        return self._by_key.get((address.type, address.hash)) if address.hash else self.types[0]

    def verdict(self, type_: ServiceType) -> Verdict:
        """Return the verdict on goals that can't be executed, as in Nav2 of the client's distribution.

        If several distributions have its layout, a goal is aborted if one of them aborts it.
        """
        return Verdict.ABORT if type_.hash in self._aborting else Verdict.ABORT_OR_REJECT

    def nearest(self, address: Address) -> ServiceType:
        """Return the layout of the reply to an unknown layout: the oldest for humble, else the newest."""
        return self.types[0 if address.hash == NO_HASH else -1]


@dataclass(frozen=True, slots=True, eq=False)
class PendingRosReply:
    """A query and its parsed key and attachment.

    Attributes:
        type: The client's layout of the service.
        attached: The attachment, which identifies the client; None on a wire without attachments.
    """

    query: zenoh.Query
    wire: Wire
    handler: Handler
    type: ServiceType
    attached: Attachment | None

    @property
    def client(self) -> str:
        """The client's id in hex; empty if it has none."""
        return self.attached.gid.hex() if self.attached and any(self.attached.gid) else ""

    def answer(self, answer: Any) -> None:
        """Send the answer to the command, in the client's layout."""
        self.reply(self.handler.refusal(answer.message) if isinstance(answer, Refused) else self.handler.answer(answer))

    def refuse(self, text: str) -> None:
        """Reject the request; *text* is the reason, if the response has a field for it."""
        self.reply(self.handler.refusal(text))

    def reply(self, values: Message | Mapping[str, Any]) -> None:
        """Send the only reply to the request."""
        try:
            self.query.reply(self.query.key_expr, self._encoded(values), attachment=self._attachment())
        except zenoh.ZError as error:
            _log.debug("replying to %s: %s", self.handler.name, error)
        finally:
            self.query.drop()

    def _encoded(self, values: Message | Mapping[str, Any]) -> bytes:
        encode = self.type.response.encode
        try:
            return encode(values)
        except CdrError as error:
            _log.exception("the reply of %s can't be serialized", self.handler.name)
            return encode(self.handler.refusal(f"the simulator has a bug: {error}"))

    def _attachment(self) -> zenoh.ZBytes | bytes | None:
        """Return the request's attachment, with the current time; unchanged on a wire without attachments."""
        if self.attached is None:
            return self.query.attachment
        return self.attached._replace(stamp=time.time_ns()).to_bytes()


@dataclass(frozen=True)
class Handler(ABC):
    """The handler of one service.

    Attributes:
        name: The service's name, such as ``/wall_e/wait/_action/send_goal``.
        lost: Whether it is no longer served: its requests are rejected, as they would get no reply otherwise.
    """

    name: str
    layouts: Layouts
    lost: bool = field(default=False, kw_only=True)

    @property
    def serving(self) -> Node:
        """The node whose service it is."""
        return WORLD_NODE

    @abstractmethod
    def commands(self, request: Mapping[str, Any], reply_to: PendingRosReply) -> list[AnyCommand]:
        """Return the commands of a request; a request that needs none is answered here.

        Raises:
            ValidationError: The request is invalid.
        """

    @abstractmethod
    def answer(self, answer: Any) -> Message | Mapping[str, Any]:
        """Return the response with the answer to the command."""

    @abstractmethod
    def refusal(self, text: str) -> Message | Mapping[str, Any]:
        """Return the response to a rejected request."""


@dataclass(frozen=True)
class ActionHandler(Handler):
    """The handler of one of an action's services."""

    robot: str
    action: AnyAction

    @property
    def serving(self) -> Node:
        """The node that serves the action."""
        return node_of(self.robot, self.action.name)


class SendGoalHandler(ActionHandler):
    """The handler of ``send_goal`` of an action."""

    def commands(self, request: Mapping[str, Any], reply_to: PendingRosReply) -> list[AnyCommand]:
        """Return the command that sends the goal."""
        goal = self.action.goal.model_validate(request["goal"])
        # The simulator's own actions, those of the world, have no other server that clients may know.
        verdict = Verdict.REJECT if self.robot == WORLD else self.layouts.verdict(reply_to.type)
        return [SendGoal(self.robot, self.action.name, goal, _goal_id(request), reply_to, verdict)]

    def answer(self, answer: GoalResponse) -> Mapping[str, Any]:
        """Return whether the goal was accepted, and when; ROS has no field for the reason of a rejection."""
        return {"accepted": answer.accepted, "stamp": values_of(answer.stamp)}

    def refusal(self, _text: str) -> Mapping[str, Any]:
        """Return that the goal was rejected."""
        return {"accepted": False, "stamp": values_of(_STAMP)}


class CancelGoalHandler(ActionHandler):
    """The handler of ``cancel_goal`` of an action."""

    def commands(self, request: Mapping[str, Any], reply_to: PendingRosReply) -> list[AnyCommand]:
        """Return the command that cancels the goals."""
        info = request["goal_info"]
        stamp = info["stamp"]["sec"] * NANOSECONDS + info["stamp"]["nanosec"]
        return [CancelGoal(self.robot, self.action.name, _goal_id(info), stamp, reply_to)]

    def answer(self, answer: CancelResponse) -> Mapping[str, Any]:
        """Return the goals that are being canceled."""
        goals = [
            {"goal_id": {"uuid": list(bytes.fromhex(goal.goal_id))}, "stamp": values_of(goal.stamp)}
            for goal in answer.goals_canceling
        ]
        return {"return_code": answer.return_code, "goals_canceling": goals}

    def refusal(self, _text: str) -> Mapping[str, Any]:
        """Return that no goal is being canceled."""
        return {"return_code": _UNKNOWN if self.lost else _REJECTED, "goals_canceling": []}


class GetResultHandler(ActionHandler):
    """The handler of ``get_result`` of an action."""

    def commands(self, request: Mapping[str, Any], reply_to: PendingRosReply) -> list[AnyCommand]:
        """Return the command that waits for the result."""
        return [GetResult(self.robot, self.action.name, _goal_id(request), reply_to)]

    def answer(self, answer: ResultResponse) -> Mapping[str, Any]:
        """Return the goal's final status and result."""
        return {"status": int(answer.status), "result": answer.result}

    def refusal(self, _text: str) -> Mapping[str, Any]:
        """Return that the goal is unknown."""
        return {"status": 0, "result": self.action.result()}


@dataclass(frozen=True)
class WorldServiceHandler(Handler):
    """The handler of a service of the world."""

    service: Service

    def commands(self, request: Mapping[str, Any], reply_to: PendingRosReply) -> list[AnyCommand]:
        """Return the command that calls the service."""
        return [CallService(self.service.name, self.service.request.model_validate(request), reply_to)]

    def answer(self, answer: Message) -> Message:
        """Return the response."""
        return answer

    def refusal(self, text: str) -> Message:
        """Return that the call failed, with the reason if the response has a field for it."""
        return _failed(self.service.response(), text)


@dataclass(frozen=True)
class NodeHandler(Handler):
    """The handler of a service of a node.

    Attributes:
        response: The type of the response. An empty one means that nothing was done.
    """

    node: Node
    simulator: Simulator
    response: type[Message]

    @property
    def serving(self) -> Node:
        """The node that serves the requests."""
        return self.node

    def refusal(self, text: str) -> Message:
        """Return an empty response, with the reason if the response has a field for it."""
        return _failed(self.response(), text)


@dataclass(frozen=True)
class ReadingHandler(NodeHandler):
    """The handler of a service that answers at once, without a command.

    Attributes:
        respond: Returns the response to a request.
    """

    respond: Callable[[Simulator, Node, Mapping[str, Any]], Message | Mapping[str, Any]]

    def commands(self, request: Mapping[str, Any], reply_to: PendingRosReply) -> list[AnyCommand]:
        """Answer at once; there are no commands."""
        if self.node.robot in self.simulator.dispatcher.cut_off:
            reply_to.refuse(no_connection(self.node.robot))
        else:
            reply_to.answer(self.respond(self.simulator, self.node, request))
        return []

    def answer(self, answer: Message | Mapping[str, Any]) -> Message | Mapping[str, Any]:
        """Return the response."""
        return answer


def _failed(response: Message, text: str) -> Message:
    """Return a response with the reason of a failure, if it has a field for that."""
    result = getattr(response, "result", None)
    if isinstance(result, Result):
        result = Result(result=Result.RESULT_OPERATION_FAILED, error_message=text)
    elif isinstance(result, SetParametersResult):
        result = SetParametersResult(reason=text)
    else:
        return response
    return response.model_copy(update={"result": result})


def _goal_id(request: Mapping[str, Any]) -> str:
    return bytes(request["goal_id"]["uuid"]).hex()
