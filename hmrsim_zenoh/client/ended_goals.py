"""What has become of a goal: its result, or an error that says why there is none worth having."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeVar

from hmrsim.actions import error_of
from hmrsim.interfaces.message import Message
from hmrsim.protocol.goal import GoalStatus
from hmrsim_zenoh.errors import GoalFailed

if TYPE_CHECKING:
    from hmrsim_zenoh.client.errands import Errand
    from hmrsim_zenoh.client.goal_handle import GoalHandle

R = TypeVar("R", bound=Message)


def checked(robot: str, errand: Errand[R], handle: GoalHandle[Any, Any]) -> R:
    """Return the result of a goal that is done.

    Raises:
        GoalFailed: It was aborted or canceled.
        HmrsimError: It was rejected, or there is no answer; as `GoalHandle.result`.
    """
    result = handle.result()
    if not isinstance(result, errand.result):
        raise TypeError(f"{errand.name} gave {result!r}")
    if handle.status is not GoalStatus.SUCCEEDED:
        text = f"{robot}: {errand.name} ended {handle.status.name}: {_why(result)}"
        raise GoalFailed(text, handle.status, result, handle.cause)
    return result


def _why(result: Message) -> str:
    """Return a result's error message: Nav2's and MoveIt's results have it in different fields."""
    code, text = getattr(result, "error_code", None), error_of(result)
    number = getattr(code, "val", code)
    return f"{text} ({number})" if text else f"error code {number}"
