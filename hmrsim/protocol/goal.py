"""The life of a goal: its statuses, its events, the one table of transitions, and answers to commands about goals.

Two rules: nothing else in hmrsim sets a status, and this module knows neither robots nor clients.

The statuses and their numbers are those of ``action_msgs/msg/GoalStatus``; the table is that of rcl_action's
goal state machine::

    ACCEPTED ──execute──► EXECUTING ──succeed──► SUCCEEDED
        │                  │  │
        │             cancel  └──abort─────────► ABORTED
        │                  ▼
        └─────cancel──► CANCELING ──canceled───► CANCELED
                           └──succeed, abort───► SUCCEEDED, ABORTED

A rejected goal never enters the machine.
"""

from __future__ import annotations

import hashlib
import re
from enum import Enum, IntEnum, StrEnum
from types import MappingProxyType
from typing import TYPE_CHECKING, Final, NamedTuple

if TYPE_CHECKING:
    from hmrsim.interfaces.message import Message


WORLD: Final = "_world"
"""The name under which the world serves actions, as a robot does under its own."""


class Verdict(StrEnum):
    """The outcome of a goal that can't be executed."""

    REJECT = "reject"
    """It is rejected with the reason."""
    ABORT = "abort"
    """It is accepted, and aborted with the reason, as by Nav2's servers of jazzy and kilted."""
    ABORT_OR_REJECT = "abort_or_reject"
    """Likewise, but rejected where Nav2's servers do so from lyrical on."""


class GoalStatus(IntEnum):
    """The status of a goal, as in action_msgs.

    Attributes:
        terminal: Whether the goal has ended.
    """

    terminal: bool

    UNKNOWN = 0
    ACCEPTED = 1
    EXECUTING = 2
    CANCELING = 3
    SUCCEEDED = 4
    CANCELED = 5
    ABORTED = 6

    def __init__(self, number: int) -> None:
        # An attribute of the members: it is looked up several times a goal.
        self.terminal = number >= 4  # noqa: PLR2004 - SUCCEEDED, which is not made yet

    @property
    def cancelable(self) -> bool:
        """Return whether a cancel request may select the goal; a canceling goal may not be canceled again."""
        return self in (GoalStatus.ACCEPTED, GoalStatus.EXECUTING)


class Cause(StrEnum):
    """Why a goal did not succeed, as an identifier; a fault that ends goals has its own, the name of its kind."""

    CANCELED = "canceled"
    """A client canceled it."""
    FAILED = "failed"
    """What was asked for can't be done; the action's error code says why."""
    BLOCKED = "blocked"
    """Traffic, or a closed lane, was in the way for too long, or for good."""
    NO_ROUTE = "no_route"
    """No way leads there."""
    PREEMPTED = "preempted"
    """Another goal took what it needed."""
    BUSY = "busy"
    """Another goal had what it needed, and kept it."""
    MOVED = "moved"
    """The robot was put somewhere else, or traffic had moved it aside since its last drive."""
    DELETED = "deleted"
    """The robot was deleted."""
    BATTERY_EMPTY = "battery_empty"
    """The robot's battery was empty."""
    DEACTIVATED = "deactivated"
    """The node that served it was deactivated."""
    RESET = "reset"
    """The simulation was reset, or another world was loaded."""
    ENDED = "ended"
    """The simulation has ended."""
    BUG = "bug"
    """The action has a bug."""


class GoalEvent(Enum):
    """The transitions of a goal."""

    __hash__ = object.__hash__
    """Enum's own is written in Python, and is most of what a transition costs."""

    EXECUTE = "execute"
    CANCEL = "cancel"
    SUCCEED = "succeed"
    ABORT = "abort"
    CANCELED = "canceled"


TRANSITIONS: Final = MappingProxyType(
    {
        (GoalStatus.ACCEPTED, GoalEvent.EXECUTE): GoalStatus.EXECUTING,
        (GoalStatus.ACCEPTED, GoalEvent.CANCEL): GoalStatus.CANCELING,
        (GoalStatus.EXECUTING, GoalEvent.CANCEL): GoalStatus.CANCELING,
        (GoalStatus.EXECUTING, GoalEvent.SUCCEED): GoalStatus.SUCCEEDED,
        (GoalStatus.EXECUTING, GoalEvent.ABORT): GoalStatus.ABORTED,
        (GoalStatus.CANCELING, GoalEvent.SUCCEED): GoalStatus.SUCCEEDED,
        (GoalStatus.CANCELING, GoalEvent.ABORT): GoalStatus.ABORTED,
        (GoalStatus.CANCELING, GoalEvent.CANCELED): GoalStatus.CANCELED,
    }
)
"""All legal transitions; all others are illegal."""


class IllegalTransition(RuntimeError):
    """An event met a goal in a status that it can't change; the status stays as it was."""


def next_status(status: GoalStatus, event: GoalEvent) -> GoalStatus:
    """Return the status that *event* leads to.

    Raises:
        IllegalTransition: The table has no such transition.
    """
    try:
        return TRANSITIONS[status, event]
    except KeyError:
        raise IllegalTransition(f"a goal that is {status.name} can't {event.value}") from None


ZERO_ID: Final = "0" * 32
"""The goal id that stands for "all goals" in a cancel request."""

_GOAL_ID = re.compile(r"[0-9a-f]{32}")
_MAX_SHOWN = 200


def parse_goal_id(text: str) -> str:
    """Return a goal id as 32 lower-case hex digits; hyphens are dropped.

    Any 16 bytes are an id: rclcpp's are not valid version-4 UUIDs either.

    Raises:
        ValueError: *text* has another form.
    """
    if _GOAL_ID.fullmatch(text):
        return text
    goal_id = text.replace("-", "").lower()
    if not _GOAL_ID.fullmatch(goal_id):
        raise ValueError(f"goal id {text[:_MAX_SHOWN]!r} is not a UUID of 32 hex digits")
    return goal_id


def made_goal_id(owner: str, number: int) -> str:
    """Return the id of the goal with this number, from 1, that *owner* sends: the same in every run."""
    return hashlib.blake2b(f"{owner}/{number}".encode(), digest_size=16).hexdigest()


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
