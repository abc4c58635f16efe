"""Commands from outside: frozen values that `Simulator.submit` takes, and the inbox that queues them.

They are named tuples, because some are created several times per goal, and frozen dataclasses take four times as long.
``reply_to`` is an object of the sender, which is returned with the answer and is opaque to the simulation.
Times are whole nanoseconds of simulated time.
"""

from __future__ import annotations

import math
import threading
from collections import deque
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

from hmrsim.errors import SimulationStopped
from hmrsim.protocol.goal import ZERO_ID, Verdict
from hmrsim.protocol.time import CheckWatchdog, Intervene, Join, Leave, ReadTime, SetClock, TokenSeen

if TYPE_CHECKING:
    from hmrsim.interfaces.message import Message
    from hmrsim.interfaces.nav2_msgs import ComputePathToPose
    from hmrsim.protocol.topics import Topic, Unwatch, Watch


class SendGoal(NamedTuple):
    """Ask a robot to pursue a goal; answered by `GoalResponse`, and to *result_to* by `ResultResponse`.

    Attributes:
        goal: The goal message; None when the action is not known, so that the message could not be decoded.
        goal_id: 32 hex digits; None lets the simulation make one; any other text is rejected.
        reply_to: Handed back with the answer.
        verdict: The outcome of a goal that can't be executed.
        result_to: Handed back with the result, if the goal is accepted, as by a `GetResult` right behind it.
    """

    robot: str
    action: str
    goal: Message | None
    goal_id: str | None = None
    reply_to: Any = None
    verdict: Verdict = Verdict.REJECT
    result_to: Any = None


class CancelGoal(NamedTuple):
    """Cancel one goal, those accepted up to a time, or all; answered by `CancelResponse`.

    Attributes:
        goal_id: 32 hex digits; all zero for no goal in particular.
        stamp: Cancel goals accepted at or before this time; 0 for goals of any time.
    """

    robot: str
    action: str
    goal_id: str = ZERO_ID
    stamp: int = 0
    reply_to: Any = None


class GetResult(NamedTuple):
    """Ask for a goal's result; answered by `ResultResponse` when the goal has ended."""

    robot: str
    action: str
    goal_id: str
    reply_to: Any = None


class ChangeState(NamedTuple):
    """Change the state of a ROS node that serves actions of a robot; answered by whether it has changed.

    Attributes:
        actions: The actions that it serves.
        transition: The number of the transition, as in lifecycle_msgs.
    """

    robot: str
    node: str
    actions: tuple[str, ...]
    transition: int
    reply_to: Any = None


class StopWaiting(NamedTuple):
    """Stop waiting for a result that was asked for with `GetResult`; ignored for requests that were answered already.

    Attributes:
        reply_tos: The *reply_to* of the requests.
        tell: Whether the waiting clients get an answer with the goal's current status.
    """

    robot: str
    action: str
    goal_id: str
    reply_tos: tuple[Any, ...]
    tell: bool = False


class ForgetResult(NamedTuple):
    """Drop the result of a goal after its timeout."""

    robot: str
    action: str
    goal_id: str


class Read(NamedTuple):
    """Ask for the latest message of a topic; answered by the event that would be published now.

    Attributes:
        robot: Of which robot; empty for the world's topics.
        action: Of which action, for `Topic.STATUS`.
    """

    topic: Topic
    robot: str = ""
    action: str = ""
    reply_to: Any = None


@dataclass(frozen=True, slots=True)
class InterestChanged:
    """A topic may have gained its first subscriber, or lost its last one."""


class CallService(NamedTuple):
    """Ask one of the world's services; answered by its response.

    Attributes:
        service: Its name, such as ``spawn_entity``.
    """

    service: str
    request: Message
    reply_to: Any = None


class Participation(NamedTuple):
    """A controller takes part in lockstep, or no longer does; published as the event ``participant_<change>``.

    Attributes:
        change: ``joined``, ``left`` or ``dropped``.
        why: Why it was dropped, or had to leave; empty if it left by itself.
    """

    participant: str
    change: str
    why: str = ""


class PlannerPresent(NamedTuple):
    """An external planner has connected or disconnected."""

    present: bool


class PlanAnswered(NamedTuple):
    """The answer of an external planner, or its failure; dropped if no goal waits for it.

    Attributes:
        request: The number that `PlanWanted` had.
        result: The path, or the reason why planning failed.
    """

    request: int
    result: ComputePathToPose.Result


class Stop(NamedTuple):
    """Abort all running goals; no further command may follow."""

    reason: str


Command = (
    SendGoal
    | CancelGoal
    | GetResult
    | ChangeState
    | StopWaiting
    | ForgetResult
    | Read
    | InterestChanged
    | CallService
    | Participation
    | PlannerPresent
    | PlanAnswered
    | Stop
)


UNRECORDED = (GetResult, StopWaiting, ForgetResult, Read, InterestChanged)
"""Commands that change nothing of the world, so that traces do without."""


def without_receivers(command: Command) -> Command:
    """Return a command for the record, without its reply objects: some close once they are garbage-collected."""
    match command:
        case SendGoal(robot, action, goal, goal_id):
            # `_replace` takes three times as long.
            return SendGoal(robot, action, goal, goal_id, verdict=command.verdict)
        case CancelGoal() | ChangeState() | CallService():
            return command._replace(reply_to=None)
        case _:
            return command


class Unreadable(NamedTuple):
    """A command of an advance that can't be read, or that its sender may not give.

    Attributes:
        answer: The answer, which the reader of the request has created.
    """

    answer: Any


class Advance(NamedTuple):
    """Ask for time to advance; answered by `Granted` when it has.

    Attributes:
        epoch: The epoch for which this is.
        until: How far time may advance; infinite for as far as anything is scheduled.
        wake: The kinds of events that end the grant, of `hmrsim.protocol.time.KINDS`.
        report: Further kinds to include in the grant; feedback once per goal.
        commands: To be applied first, in this order; each has its own answer. Conditions stay until they are met.
    """

    participant: str
    epoch: int
    until: float = math.inf
    wake: frozenset[str] = frozenset()
    report: frozenset[str] = frozenset()
    commands: tuple[SendGoal | CancelGoal | GetResult | Watch | Unwatch | Unreadable, ...] = ()
    reply_to: Any = None


TimeCommand = Join | Advance | Leave | TokenSeen | SetClock | ReadTime | CheckWatchdog | Intervene


AnyCommand = Command | TimeCommand
"""All commands: about the world, or about its time."""


class Inbox:
    """Commands on their way in, in order of arrival; any thread may put.

    Reading is for the simulation's thread. A subclass may bring commands in by another way.

    Attributes:
        closed: Whether the inbox accepts no further commands.
    """

    def __init__(self) -> None:
        self._commands: deque[AnyCommand] = deque()
        self._changed = threading.Condition()
        self.closed = False

    def put(self, command: AnyCommand) -> None:
        """Add a command and wake the simulation.

        Raises:
            SimulationStopped: The inbox is closed.
        """
        with self._changed:
            if self.closed:
                raise SimulationStopped("the simulation has ended")
            self._commands.append(command)
            self._changed.notify()

    @property
    def waiting(self) -> bool:
        """Return whether a command is waiting in the inbox."""
        return bool(self._commands)

    def poll(self) -> AnyCommand | None:
        """Return the next command, or None if the inbox is empty."""
        return self._commands.popleft() if self._commands else None

    def wait(self, timeout: float | None) -> None:
        """Return when there is a command, the inbox was closed, or *timeout* seconds of wall time have passed."""
        with self._changed:
            self._changed.wait_for(lambda: self._commands or self.closed, timeout)

    def close(self) -> None:
        """Close the inbox, and wake the simulation."""
        if self.closed:
            return
        with self._changed:
            self.closed = True
            self._changed.notify_all()
