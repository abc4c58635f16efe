"""What can happen to a node, and how the goals of action leaves end."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

from hmrsim.errors import GoalRejected
from hmrsim.protocol.goal import GoalStatus
from hmrsim_zenoh.errors import SimulatorGone

if TYPE_CHECKING:
    from hmrsim_zenoh.client.goal_handle import GoalHandle

SUCCESS: Final = "SUCCESS"
FAILURE: Final = "FAILURE"
RUNNING: Final = "RUNNING"
SKIPPED: Final = "SKIPPED"
"""A tick without a result, as nodes of XML trees have it."""
CANCELED: Final = "CANCELED"
"""The node was halted or suspended while it was running, or another client canceled its goal."""
RECOVERED: Final = "RECOVERED"
"""The node failed, and a node above it that tries something else, or the same again, succeeded nevertheless."""
REJECTED: Final = "REJECTED"
"""The goal was not accepted."""
PREEMPTED: Final = "PREEMPTED"
"""Another goal took the robot's base."""
LOST: Final = "LOST"
"""Nobody knows how the goal ended."""

ABORTED: Final = "ABORTED/"
"""The goal was aborted; the error code follows."""

ENDINGS: Final = (SUCCESS, FAILURE, CANCELED, RECOVERED)
"""The outcomes that count for the share of a tree that is covered."""

WORDS: Final[Mapping[str, str]] = MappingProxyType(
    {SUCCESS: "succeeded", FAILURE: "failed", CANCELED: "canceled", RECOVERED: "recovered"}
)
"""What a node has done, by outcome."""

TICKED: Final = "ticked"

_PREEMPTED: Final = "preempted"
_ENDED: Final = "ended"


def ended_with_run(handle: GoalHandle[Any, Any] | None) -> bool:
    """Return whether a goal has ended since the simulation has, which says nothing about the tree."""
    return handle is not None and (handle.cause == _ENDED or isinstance(handle.error, SimulatorGone))


def ending_of(handle: GoalHandle[Any, Any]) -> str | None:
    """Return how a goal that is done has ended; None if it succeeded."""
    if handle.error is not None:
        return REJECTED if isinstance(handle.error, GoalRejected) else LOST
    match handle.status:
        case GoalStatus.SUCCEEDED:
            return None
        case GoalStatus.CANCELED:
            return CANCELED
    return PREEMPTED if handle.cause == _PREEMPTED else f"{ABORTED}{_code_of(handle.result_message)}"


def _code_of(result: Any) -> int:
    """Return the error code of a result of Nav2, MoveIt or the simulation; 0 if it has none."""
    own = getattr(getattr(result, "result", None), "result", 0)
    code: Any = getattr(result, "error_code", own)
    return int(getattr(code, "val", code))
