"""What ROS clients can ask of us, one class a kind: how a request becomes a command, and an answer ROS's message.

Several layouts of one service may be on offer, as distributions have different ones; the key of a request says which.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, Protocol

from hmrsim.interfaces.action_msgs import CancelGoal as CancelGoalService
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS, values_of
from hmrsim.interfaces.lifecycle_msgs import GetState, State
from hmrsim.interfaces.simulation_interfaces import Result
from hmrsim.protocol.answers import Refused
from hmrsim.protocol.commands import CallService, CancelGoal, GetResult, SendGoal
from hmrsim_zenoh.ros2.keys import NO_HASH

if TYPE_CHECKING:
    from collections.abc import Mapping

    from hmrsim.actions import AnyAction
    from hmrsim.interfaces.message import Message
    from hmrsim.protocol.answers import CancelResponse, GoalResponse, ResultResponse
    from hmrsim.protocol.commands import AnyCommand
    from hmrsim.services import AnyService
    from hmrsim_zenoh.ros2.codec.types import ServiceType
    from hmrsim_zenoh.ros2.keys import Address

_REJECTED: Final = CancelGoalService.Response.ERROR_REJECTED
_UNKNOWN: Final = CancelGoalService.Response.ERROR_UNKNOWN_GOAL_ID
_STAMP: Final = 1
"""Of goals that are not accepted, in nanoseconds: ROS takes 0 for no time at all."""


class Layouts:
    """The layouts of one service.

    Attributes:
        types: One for each distribution, in order of their age.
    """

    def __init__(self, types: tuple[ServiceType, ...]) -> None:
        self.types = types
        self._by_key = {(one.dds_name, one.hash): one for one in types}

    def of(self, address: Address) -> ServiceType | None:
        """Return the layout that a key names; the first where keys have none; None if it is none of ours."""
        return self._by_key.get((address.type, address.hash)) if address.hash else self.types[0]

    def nearest(self, address: Address) -> ServiceType:
        """Return the layout to answer in if a key names none of ours: the oldest for humble, else the newest."""
        return self.types[0 if address.hash == NO_HASH else -1]


class ReplyTo(Protocol):
    """A request that awaits its reply."""

    def answer(self, answer: Any) -> None:
        """Send what came of the command."""


class Offer(Protocol):
    """One service.

    Attributes:
        name: ROS's, such as ``/wall_e/wait/_action/send_goal``.
        layouts: In which layouts.
        lost: Whether it was there and is no longer: its requests are refused, as they would get no reply otherwise.
    """

    @property
    def name(self) -> str: ...  # noqa: D102

    @property
    def layouts(self) -> Layouts: ...  # noqa: D102

    @property
    def lost(self) -> bool: ...  # noqa: D102

    def commands(self, request: Mapping[str, Any], reply_to: ReplyTo) -> list[AnyCommand]:
        """Return the commands that a request stands for; what needs none is answered.

        Raises:
            ValidationError: The request makes no sense.
        """

    def answer(self, answer: Any) -> Message | Mapping[str, Any]:
        """Return the response to what came of the command."""

    def refusal(self, text: str) -> Message | Mapping[str, Any]:
        """Return the response to what came to nothing."""


@dataclass(frozen=True)
class OfAction:
    """One of the services of an action.

    Attributes:
        name: ROS's.
        layouts: In which layouts.
        robot: Whose.
        action: Which.
        lost: Whether it is no longer there.
    """

    name: str
    layouts: Layouts
    robot: str
    action: AnyAction
    lost: bool = False


class Goals(OfAction):
    """Takes goals."""

    def commands(self, request: Mapping[str, Any], reply_to: ReplyTo) -> list[AnyCommand]:
        """Return the goal that is sent."""
        goal = self.action.goal.model_validate(request["goal"])
        return [SendGoal(self.robot, self.action.name, goal, _goal_id(request), reply_to)]

    def answer(self, answer: GoalResponse) -> Mapping[str, Any]:
        """Return whether it was accepted, and when; ROS has no field for why not."""
        return {"accepted": answer.accepted, "stamp": values_of(answer.stamp)}

    def refusal(self, _text: str) -> Mapping[str, Any]:
        """Return that it was not accepted."""
        return {"accepted": False, "stamp": values_of(_STAMP)}


class Cancels(OfAction):
    """Takes requests to cancel goals."""

    def commands(self, request: Mapping[str, Any], reply_to: ReplyTo) -> list[AnyCommand]:
        """Return the request."""
        info = request["goal_info"]
        stamp = info["stamp"]["sec"] * NANOSECONDS + info["stamp"]["nanosec"]
        return [CancelGoal(self.robot, self.action.name, _goal_id(info), stamp, reply_to)]

    def answer(self, answer: CancelResponse | Refused) -> Mapping[str, Any]:
        """Return which goals are canceled."""
        if isinstance(answer, Refused):
            return self.refusal(answer.message)
        goals = [
            {"goal_id": {"uuid": list(bytes.fromhex(goal.goal_id))}, "stamp": values_of(goal.stamp)}
            for goal in answer.goals_canceling
        ]
        return {"return_code": answer.return_code, "goals_canceling": goals}

    def refusal(self, _text: str) -> Mapping[str, Any]:
        """Return that none is."""
        return {"return_code": _UNKNOWN if self.lost else _REJECTED, "goals_canceling": []}


class Results(OfAction):
    """Hands out results, when there are any."""

    def commands(self, request: Mapping[str, Any], reply_to: ReplyTo) -> list[AnyCommand]:
        """Return the request."""
        return [GetResult(self.robot, self.action.name, _goal_id(request), reply_to)]

    def answer(self, answer: ResultResponse | Refused) -> Mapping[str, Any]:
        """Return how the goal ended."""
        if isinstance(answer, Refused):
            return self.refusal(answer.message)
        return {"status": int(answer.status), "result": answer.result}

    def refusal(self, _text: str) -> Mapping[str, Any]:
        """Return that nothing is known of the goal."""
        return {"status": 0, "result": self.action.result()}


@dataclass(frozen=True)
class OfWorld:
    """A service of the world.

    Attributes:
        name: ROS's.
        layouts: In which layouts.
        service: Which.
    """

    name: str
    layouts: Layouts
    service: AnyService

    lost = False

    def commands(self, request: Mapping[str, Any], reply_to: ReplyTo) -> list[AnyCommand]:
        """Return the request."""
        return [CallService(self.service.name, self.service.request.model_validate(request), reply_to)]

    def answer(self, answer: Message | Refused) -> Message:
        """Return the response."""
        return self.refusal(answer.message) if isinstance(answer, Refused) else answer

    def refusal(self, text: str) -> Message:
        """Return that it failed, and why if the response can say so."""
        response: Message = self.service.response()
        if not isinstance(getattr(response, "result", None), Result):
            return response
        failed = Result(result=Result.RESULT_OPERATION_FAILED, error_message=text)
        return response.model_copy(update={"result": failed})


@dataclass(frozen=True)
class States:
    """Tells the state of a node, which is active as long as it is there.

    Attributes:
        name: ROS's.
        layouts: In which layouts.
        lost: Whether the node is no longer there.
    """

    name: str
    layouts: Layouts
    lost: bool = False

    def commands(self, _request: Mapping[str, Any], reply_to: ReplyTo) -> list[AnyCommand]:
        """Answer, and return nothing."""
        reply_to.answer(None)
        return []

    def answer(self, _answer: object) -> Message:
        """Return that it is active."""
        return GetState.Response(current_state=State(id=State.PRIMARY_STATE_ACTIVE, label="active"))

    def refusal(self, _text: str) -> Message:
        """Return that nothing is known of it."""
        return GetState.Response()


def _goal_id(request: Mapping[str, Any]) -> str:
    return bytes(request["goal_id"]["uuid"]).hex()
