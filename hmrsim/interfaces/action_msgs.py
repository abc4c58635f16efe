"""The messages that all actions share: goal ids, statuses, and the request to cancel goals."""

from __future__ import annotations

from typing import ClassVar

from pydantic import Field

from hmrsim.interfaces.builtin_interfaces import Time
from hmrsim.interfaces.message import Int8, Message
from hmrsim.interfaces.unique_identifier_msgs import UUID


class GoalInfo(Message):
    """A goal's id and the simulated time of its acceptance."""

    goal_id: UUID = Field(default_factory=UUID)
    stamp: Time = Field(default_factory=Time)


class GoalStatus(Message):
    """The status of a goal, with the numbers of ``hmrsim.protocol.goal.GoalStatus``."""

    STATUS_UNKNOWN: ClassVar[int] = 0
    STATUS_ACCEPTED: ClassVar[int] = 1
    STATUS_EXECUTING: ClassVar[int] = 2
    STATUS_CANCELING: ClassVar[int] = 3
    STATUS_SUCCEEDED: ClassVar[int] = 4
    STATUS_CANCELED: ClassVar[int] = 5
    STATUS_ABORTED: ClassVar[int] = 6

    goal_info: GoalInfo = Field(default_factory=GoalInfo)
    status: Int8 = 0


class GoalStatusArray(Message):
    """The status of every goal that an action server remembers."""

    status_list: list[GoalStatus] = Field(default_factory=list)


class CancelGoal:
    """Cancel one goal, all goals, or all goals accepted up to a time."""

    class Request(Message):
        """The goals, by id or by acceptance at or before the stamp; if both are zero, all of them."""

        goal_info: GoalInfo = Field(default_factory=GoalInfo)

    class Response(Message):
        """The goals that are now canceling, or why there are none."""

        ERROR_NONE: ClassVar[int] = 0
        ERROR_REJECTED: ClassVar[int] = 1
        ERROR_UNKNOWN_GOAL_ID: ClassVar[int] = 2
        ERROR_GOAL_TERMINATED: ClassVar[int] = 3

        return_code: Int8 = 0
        goals_canceling: list[GoalInfo] = Field(default_factory=list)
