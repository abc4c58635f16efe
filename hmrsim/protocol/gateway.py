"""The seam between the simulation and everything outside: commands in, events out, both plain frozen values.

They are named tuples: some are made several times a goal, and a frozen dataclass takes four times as long to make.

A command waits in an `Inbox` until the simulation's own thread takes it; what comes of it goes to every `Sink`.
``reply_to`` is whatever the sender wants back with the answer; the simulation only hands it on.
Times are whole nanoseconds of simulated time.
"""

from __future__ import annotations

import math
import threading
from collections import deque
from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, runtime_checkable

from hmrsim.errors import SimulationStopped
from hmrsim.events.goals import GoalStatusChanged
from hmrsim.protocol.goal import ZERO_ID, GoalStatus
from hmrsim.protocol.time import HasLeft, Join, Joined, Leave, LookAround, ReadTime, SetClock, TimeState, TokenSeen

if TYPE_CHECKING:
    from collections.abc import Mapping

    from hmrsim.events import Event as WorldEvent
    from hmrsim.interfaces.message import Message
    from hmrsim.interfaces.nav2_msgs import ComputePathToPose


# --- commands --------------------------------------------------------------------------------------------------------


class SendGoal(NamedTuple):
    """Ask a robot to pursue a goal; answered by `GoalResponse`.

    Attributes:
        robot: Its name.
        action: The action's name.
        goal: The goal message; None when the action is not known, so that nobody could read it.
        goal_id: 32 hex digits; None lets the simulation make one; any other text is rejected.
        reply_to: Handed back with the answer.
    """

    robot: str
    action: str
    goal: Message | None
    goal_id: str | None = None
    reply_to: Any = None


class CancelGoal(NamedTuple):
    """Cancel one goal, those accepted up to a time, or all; answered by `CancelResponse`.

    Attributes:
        robot: Its name.
        action: The action's name.
        goal_id: 32 hex digits; all zero for no goal in particular.
        stamp: Cancel what was accepted at or before this time; 0 for no time in particular.
        reply_to: Handed back with the answer.
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


class StopWaiting(NamedTuple):
    """Let some wait no longer who asked with `GetResult`; nothing happens to those who were answered already.

    Attributes:
        robot: Its name.
        action: The action's name.
        goal_id: Whose result was asked for.
        reply_tos: What the requests had.
        tell: Whether they are answered with the status that the goal has now; those who have gone need no answer.
    """

    robot: str
    action: str
    goal_id: str
    reply_tos: tuple[Any, ...]
    tell: bool = False


class ForgetResult(NamedTuple):
    """Drop the result of a goal that ended long ago."""

    robot: str
    action: str
    goal_id: str


class Topic(Enum):
    """What is published, as far as interest in it is concerned."""

    STATUS = "status"
    FEEDBACK = "feedback"
    ODOM = "odom"
    BATTERY_STATE = "battery_state"
    DETECTIONS = "detections"
    CLOCK = "clock"
    EVENTS = "events"
    MOTION = "motion"
    """Those of the events that no trace has (`hmrsim.events.Event.traced`)."""
    TIME = "time/state"
    """How time moves, and whom it waits for."""


class Read(NamedTuple):
    """Ask for the latest of a topic; answered by the event that would be published now.

    Attributes:
        topic: Which.
        robot: Of which robot; empty for the world's topics.
        action: Of which action, for `Topic.STATUS`.
        reply_to: Handed back with the answer.
    """

    topic: Topic
    robot: str = ""
    action: str = ""
    reply_to: Any = None


@dataclass(frozen=True, slots=True)
class InterestChanged:
    """Somebody began or ceased to listen to a topic."""


class CallService(NamedTuple):
    """Ask one of the world's services; answered by its response.

    Attributes:
        service: Its name, such as ``spawn_entity``.
        request: Its request.
        reply_to: Handed back with the answer.
    """

    service: str
    request: Message
    reply_to: Any = None


class Participation(NamedTuple):
    """A controller takes part in lockstep, or does so no longer; told as the event ``participant_<change>``.

    Attributes:
        participant: Its name.
        change: ``joined``, ``left`` or ``dropped``.
        why: Why it was dropped, or had to leave; empty if of its own accord.
    """

    participant: str
    change: str
    why: str = ""


class PlannerPresent(NamedTuple):
    """A planner outside has come, or has gone."""

    present: bool


class PlanAnswered(NamedTuple):
    """A planner outside has answered, or can't any more; dropped if nobody waits for it.

    Attributes:
        request: The number that `PlanWanted` had.
        result: The path, or why there is none.
    """

    request: int
    result: ComputePathToPose.Result


class Stop(NamedTuple):
    """Abort every goal that runs; nothing may come after it."""

    reason: str


Command = (
    SendGoal
    | CancelGoal
    | GetResult
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


class Advance(NamedTuple):
    """Let time move; answered by `Granted` when it has.

    Attributes:
        participant: Who.
        epoch: The epoch for which this is.
        until: As far as time may move; infinite for as far as anything is scheduled.
        wake: What to be granted at once for, of `participation.KINDS`.
        report: What to be told of besides when time is granted; feedback once a goal.
        commands: To be applied first, in this order.
        reply_to: Handed back with the answer.
    """

    participant: str
    epoch: int
    until: float = math.inf
    wake: frozenset[str] = frozenset()
    report: frozenset[str] = frozenset()
    commands: tuple[SendGoal | CancelGoal, ...] = ()
    reply_to: Any = None


TimeCommand = Join | Advance | Leave | TokenSeen | SetClock | ReadTime | LookAround

AnyCommand = Command | TimeCommand
"""What comes in: about the world, or about its time."""


# --- answers ---------------------------------------------------------------------------------------------------------


class GoalResponse(NamedTuple):
    """What became of a `SendGoal`.

    Attributes:
        accepted: Whether the robot pursues the goal.
        goal_id: The goal's id, as given or made; the text that was sent if it is no id.
        stamp: When it was accepted; of a duplicate, when the first one was.
        reason: Why not, for programs.
        error_code: Why not, as the action's result would say it.
        error_msg: Why not, for people.
        status: What the goal of that id is now, for a duplicate.
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
    """What became of a `CancelGoal`; *return_code* is that of action_msgs/srv/CancelGoal."""

    return_code: int
    goals_canceling: tuple[GoalEntry, ...] = ()


class ResultResponse(NamedTuple):
    """How a goal ended; *result* is the action's defaults where *status* is unknown."""

    status: GoalStatus
    result: Message


class Refused(NamedTuple):
    """The request can't be served at all, because the robot or action that it names isn't there."""

    field: str
    value: object
    message: str


# --- events ----------------------------------------------------------------------------------------------------------


class Answered(NamedTuple):
    """The answer to a command; each command with a *reply_to* gets exactly one."""

    reply_to: Any
    answer: GoalResponse | CancelResponse | ResultResponse | Refused | Published | Message | TimeAnswer


class GoalChanged(NamedTuple):
    """One goal has another status; *goal* is there when it is accepted, *result* once the status is terminal."""

    stamp: int
    robot: str
    action: str
    goal_id: str
    status: GoalStatus
    goal: Message | None = None
    result: Message | None = None

    def event(self, *, results_from: GoalStatus = GoalStatus.SUCCEEDED) -> GoalStatusChanged:
        """Return it as an event of the world; with the result in plain values, from some terminal status on."""
        wanted = self.result is not None and self.status >= results_from
        result = self.result.model_dump(mode="json") if wanted and self.result is not None else None
        return GoalStatusChanged(self.robot, self.action, self.goal_id, int(self.status), result)


class StatusChanged(NamedTuple):
    """All goals kept of one robot's action, in order of acceptance, after one of them changed."""

    robot: str
    action: str
    goals: tuple[GoalEntry, ...]


class FeedbackSent(NamedTuple):
    """How a goal is doing.

    Attributes:
        robot: Its name.
        action: The action's name.
        goal_id: Whose feedback it is.
        feedback: The action's feedback message, or the same in plain values.
        last: Whether the goal ends right after it, so that it must not be thinned out.
    """

    robot: str
    action: str
    goal_id: str
    feedback: Message | Mapping[str, Any]
    last: bool = False


class Sampled(NamedTuple):
    """The latest of a topic that has one ROS message; *robot* is empty for the world's."""

    topic: Topic
    robot: str
    message: Message


@dataclass(frozen=True, slots=True)
class RosterChanged:
    """Robots have come or gone, or all of the world is another."""


class PlanWanted(NamedTuple):
    """A robot needs a path of the planner outside; answered by `PlanAnswered`.

    Attributes:
        request: Its number, which no other has.
        robot: The robot's name.
        goal: From where to where.
    """

    request: int
    robot: str
    goal: ComputePathToPose.Goal


class Happened(NamedTuple):
    """Something happened in the world.

    Attributes:
        stamp: When.
        event: What.
    """

    stamp: int
    event: WorldEvent

    @property
    def kind(self) -> str:
        """What happened, by its kind."""
        return self.event.kind

    @property
    def fields(self) -> dict[str, Any]:
        """To whom and how; JSON values, though arrays may be tuples."""
        return self.event.as_dict()


class Granted(NamedTuple):
    """Time has moved.

    Attributes:
        epoch: The next one.
        now: The simulated time.
        reason: ``event``, ``until``, ``idle`` or ``end``.
        accepted: What came of each command, in order.
        events: What happened of the kinds that were asked for, in order, each with its kind and its stamp.
    """

    epoch: int
    now: float
    reason: str
    accepted: tuple[GoalResponse | CancelResponse | Refused, ...] = ()
    events: tuple[tuple[str, int, GoalChanged | FeedbackSent], ...] = ()


TimeAnswer = Joined | Granted | HasLeft | TimeState

Published = StatusChanged | FeedbackSent | Sampled | Happened
Event = (
    Answered | GoalChanged | StatusChanged | FeedbackSent | Sampled | Happened | RosterChanged | PlanWanted | TimeState
)


class Moment(NamedTuple):
    """When a command came, as exactly as a replay needs it.

    Attributes:
        taken: The events that had been taken.
        now: The simulated time, in seconds.
    """

    taken: int
    now: float


class Sink(Protocol):
    """Where events go; called in the simulation's thread, which it must not block."""

    def emit(self, event: Event) -> None:
        """Take an event."""

    def wants(self, topic: Topic) -> bool:
        """Return whether anybody listens: what nobody wants is not computed."""


@runtime_checkable
class CommandSink(Sink, Protocol):
    """A sink that is told of commands, too."""

    def commanded(self, command: Command, by: str, moment: Moment) -> None:
        """Take a command from outside, before it is applied; *by* is the participant that sent it, if one did."""


class Inbox:
    """Commands on their way in, in order of arrival; any thread may put.

    Reading is for the simulation's thread. A subclass may bring commands in by another way.
    """

    def __init__(self) -> None:
        self._commands: deque[AnyCommand] = deque()
        self._changed = threading.Condition()
        self._closed = False

    @property
    def closed(self) -> bool:
        """Whether no more commands will come."""
        return self._closed

    def put(self, command: AnyCommand) -> None:
        """Add a command and wake the simulation.

        Raises:
            SimulationStopped: The inbox is closed.
        """
        with self._changed:
            if self._closed:
                raise SimulationStopped("the simulation has ended")
            self._commands.append(command)
            self._changed.notify()

    @property
    def waiting(self) -> bool:
        """Whether a command is there to be taken."""
        return bool(self._commands)

    def poll(self) -> AnyCommand | None:
        """Return the next command; None when there is none now."""
        return self._commands.popleft() if self._commands else None

    def wait(self, timeout: float | None) -> None:
        """Return when there is a command, the inbox was closed, or *timeout* seconds of wall time have passed."""
        with self._changed:
            self._changed.wait_for(lambda: self._commands or self._closed, timeout)

    def close(self) -> None:
        """Take no more commands, and wake the simulation."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()
