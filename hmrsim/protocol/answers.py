"""Answers to commands about goals; times are whole nanoseconds of simulated time."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from hmrsim.interfaces.message import Message
    from hmrsim.protocol.goal import GoalStatus


class GoalResponse(NamedTuple):
    """The answer to a `SendGoal`.

    Attributes:
        goal_id: The goal's id, as sent or generated; an invalid id is returned as it was sent.
        stamp: When it was accepted; of a duplicate, when the first one was.
        reason: The reason for a rejection, as an identifier.
        error_code: The reason as a code of the action's result.
        error_msg: The reason as text.
        status: The status of the goal with that id, for a duplicate.
    """

    accepted: bool
    goal_id: str
    stamp: int
    reason: str = ""
    error_code: int = 0
    error_msg: str = ""
    status: GoalStatus | None = None


class GoalEntry(NamedTuple):
    """One goal in a status list."""

    goal_id: str
    stamp: int
    status: GoalStatus


class CancelResponse(NamedTuple):
    """The answer to a `CancelGoal`; *return_code* is that of action_msgs/srv/CancelGoal."""

    return_code: int
    goals_canceling: tuple[GoalEntry, ...] = ()


class ResultResponse(NamedTuple):
    """The outcome of a goal; *result* has the action's defaults where *status* is unknown.

    **cause* is the reason why it did not succeed, as an identifier.
    """

    status: GoalStatus
    result: Message
    cause: str = ""


class Refused(NamedTuple):
    """The request can't be served at all, because the robot or action that it names does not exist."""

    field: str
    value: object
    message: str
