"""The outputs of a simulation to its sinks: answers, changes of goals, samples, and events of the world."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, Any, NamedTuple

from hmrsim.events.goals import GoalAccepted, GoalStatusChanged
from hmrsim.protocol.goal import GoalStatus
from hmrsim.protocol.time import HasLeft, Joined, TimeState

if TYPE_CHECKING:
    from hmrsim.events import Event
    from hmrsim.interfaces.message import Message
    from hmrsim.interfaces.nav2_msgs import ComputePathToPose
    from hmrsim.protocol.goal import CancelResponse, GoalEntry, GoalResponse, Refused, ResultResponse
    from hmrsim.protocol.topics import Topic
    from hmrsim.world.model import World


class Answered(NamedTuple):
    """The answer to a command: one for each *reply_to*, and one for the *result_to* of a goal that is accepted."""

    reply_to: Any
    answer: GoalResponse | CancelResponse | ResultResponse | Refused | Published | Message | TimeAnswer


class Receiver:
    """A ``reply_to`` that takes the answer itself; sinks do not receive it."""

    __slots__ = ()

    def succeed(self, answer: Any) -> None:
        """Take the answer, in the simulation's thread."""
        raise NotImplementedError


class GoalChanged(NamedTuple):
    """The status of a goal has changed; *goal* is set upon acceptance, *result* with a terminal status.

    **cause* is the reason why it did not succeed, as an identifier, else empty.
    """

    stamp: int
    robot: str
    action: str
    goal_id: str
    status: GoalStatus
    goal: Message | None = None
    result: Message | None = None
    cause: str = ""

    def accepted(self) -> GoalAccepted:
        """Return the event of an accepted goal, with the fields of its message that were set."""
        asked = self.goal.model_dump(mode="json", exclude_unset=True) if self.goal else None
        return GoalAccepted(self.robot, self.action, self.goal_id, asked)

    def event(self, *, results_from: GoalStatus = GoalStatus.SUCCEEDED) -> GoalStatusChanged:
        """Return it as an event of the world; with the result in plain values, from some terminal status on."""
        wanted = self.result is not None and self.status >= results_from
        result = self.result.model_dump(mode="json") if wanted and self.result is not None else None
        return GoalStatusChanged(self.robot, self.action, self.goal_id, int(self.status), result, self.cause or None)


class GoalTold(NamedTuple):
    """A change of a goal reaches clients later than it happened, as updates about its robot are delayed."""

    change: GoalChanged


class StatusChanged(NamedTuple):
    """All goals kept of one robot's action, in order of acceptance, after one of them changed."""

    robot: str
    action: str
    goals: tuple[GoalEntry, ...]


class FeedbackSent(NamedTuple):
    """Feedback that a goal has sent.

    Attributes:
        feedback: The action's feedback message, or the same in plain values.
        last: Whether the goal ends right after it, so that rate limits must not drop it.
    """

    robot: str
    action: str
    goal_id: str
    feedback: Message | Mapping[str, Any]
    last: bool = False


class Sampled(NamedTuple):
    """The latest message of a topic; *robot* is empty for the world's topics."""

    topic: Topic
    robot: str
    message: Message


@dataclass(frozen=True, slots=True)
class RosterChanged:
    """Robots were added or removed, or another world was loaded."""


@dataclass(frozen=True, slots=True)
class OrdersChanged:
    """An order of the demand was placed or has changed."""


class Restart(StrEnum):
    """Why simulated time begins anew."""

    RESET = "reset"
    TIME_RESET = "time_reset"
    STOPPED = "stopped"
    WORLD_LOADED = "world_loaded"


class TimeRestarted(NamedTuple):
    """Simulated time was reset to 0, which begins a new section of a trace.

    Attributes:
        ended: The time at which it ended, in nanoseconds.
        cause: Why it began anew.
        loaded: The world that was loaded; None if it is the same as before.
    """

    ended: int
    cause: Restart
    loaded: World | None = None


class PlanWanted(NamedTuple):
    """A robot needs a path from the external planner; answered by `PlanAnswered`.

    Attributes:
        request: Its unique number.
        goal: The start and the goal of the path.
    """

    request: int
    robot: str
    goal: ComputePathToPose.Goal


class EventStamped(NamedTuple):
    """An event of the world, with its time."""

    stamp: int
    event: Event

    @property
    def kind(self) -> str:
        """The kind of the event, as on the wire."""
        return self.event.kind

    @property
    def fields(self) -> dict[str, Any]:
        """The event's fields as JSON values, though arrays may be tuples."""
        return self.event.as_dict()


class Granted(NamedTuple):
    """The answer to a request to advance time.

    Attributes:
        epoch: The next one.
        reason: ``event``, ``until``, ``idle`` or ``end``.
        accepted: The answer to each command, in order; None for a result that there is not yet.
        events: The events of the requested kinds, in order, each with its kind and its stamp.
        met: The names of the conditions that were met, and are watched no longer.
        over: The reason why the run has ended, if that is why no further time is granted.
    """

    epoch: int
    now: float
    reason: str
    accepted: tuple[Any, ...] = ()
    events: tuple[tuple[str, int, GoalChanged | FeedbackSent], ...] = ()
    met: tuple[str, ...] = ()
    over: str = ""


TimeAnswer = Joined | Granted | HasLeft | TimeState


Published = StatusChanged | FeedbackSent | Sampled | EventStamped


Output = (
    Answered
    | GoalChanged
    | GoalTold
    | StatusChanged
    | FeedbackSent
    | Sampled
    | EventStamped
    | RosterChanged
    | OrdersChanged
    | TimeRestarted
    | PlanWanted
    | TimeState
)
