"""The actions of robots, one per file.

An action is data: a name, its ROS types, one process and its error codes. Server, client, behavior, schema
and tests are generic over it. This package does not import simpy, so that a controller may import it, too.
"""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable, Generator, Iterable, Mapping, Set
from dataclasses import dataclass, field
from functools import cache, cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Generic, NamedTuple, Protocol, TypeVar

from hmrsim.actions._inputs import Input, goal_schema, title_of
from hmrsim.interfaces.message import Message
from hmrsim.plugins import discover
from hmrsim.protocol.goal import Cause

if TYPE_CHECKING:
    from hmrsim.world.model import World

G = TypeVar("G", bound=Message)
R = TypeVar("R", bound=Message)
F = TypeVar("F", bound=Message)
F_contra = TypeVar("F_contra", bound=Message, contravariant=True)

FRAMES = ("", "map")
"""The frames of poses: the map, by its name or as the default."""


_NO_ERRORS = frozenset({"NONE", "SUCCESS", "UNDEFINED", "GOAL_REJECTED", "SEND_GOAL_FAILURE", "ALL_GOALS"})
"""The codes of results that no server aborts a goal with: what clients note, and what is none."""


_PASSED_ON = MappingProxyType(
    {
        "navigate_to_pose": ("compute_path_to_pose", "follow_path"),
        "navigate_through_poses": ("compute_path_through_poses", "follow_path"),
    }
)
"""The actions whose codes are in the results of others."""


def unknown_frame(frame: str) -> str:
    """Return what is wrong with the frame of a goal's pose."""
    return f"unknown frame_id {frame!r}; use 'map' or leave it empty"


class Report(Protocol[F_contra]):
    """Publishes the feedback of an executing goal."""

    def send(self, feedback: F_contra | Mapping[str, Any]) -> None:
        """Publish this feedback, or its plain values, now."""

    def sample(self, source: Callable[[], F_contra | Mapping[str, Any]]) -> None:
        """Publish the feedback of *source*, or its plain values, at the feedback rate, and when the goal ends."""

    def on_failure(self, make: Callable[[int, str], Any]) -> None:
        """Use *make* in place of the action's *failure* to build the result if the goal does not succeed."""


@dataclass(frozen=True)
class Codes:
    """The error codes that the dispatcher needs of an action; the others are its own.

    Attributes:
        canceled: In the result of a canceled goal.
        preempted: ... of a goal that another goal preempted.
        rejected: In the answer to a rejected goal.
        unknown: The code for errors that have no specific one.
        busy: For a goal that finds the base held; None when it preempts the goal that holds the base.
        tf_error: For a pose in an unknown frame; None for *unknown*.
    """

    canceled: int
    preempted: int
    rejected: int
    unknown: int
    busy: int | None = None
    tf_error: int | None = None

    @classmethod
    def of_nav2(cls, result: Any) -> Codes:
        """Return the codes of an action of Nav2, whose result type has ``UNKNOWN``; it preempts."""
        unknown, tf_error = result.UNKNOWN, getattr(result, "TF_ERROR", None)
        return cls(canceled=0, preempted=unknown, rejected=1, unknown=unknown, tf_error=tf_error)


class Flaw(NamedTuple):
    """Why no robot could execute a goal, and the code of the action's result for that."""

    text: str
    code: int


@dataclass(frozen=True)
class Order(Generic[G]):
    """The order in scripts for an action.

    Attributes:
        word: The first word of the line, such as ``Go``.
        usage: The syntax of its arguments, as text.
        goal: Makes the goal of what follows; names are looked up in the world. Raises ValueError, whose text says
            what is wrong, when it makes no sense there.
    """

    word: str
    usage: str
    goal: Callable[[str, World], G]


@dataclass(frozen=True)
class Action(Generic[G, R, F]):
    """An action of robots or of the world.

    Attributes:
        name: Its name in keys, and that of its module.
        goal: The goal's message type.
        result: The result's message type.
        feedback: The feedback's message type.
        process: Executes one goal: yields simulation events, returns the result. Raises `GoalAborted` when it
            can't be done. An interrupt means that the goal is canceled or preempted: leave the robot usable.
        failure: Makes the result of a goal that ended otherwise, from a code and a text.
        codes: The codes for that.
        of_world: Whether the world serves it, and no robot: *process* is given its `hmrsim.simulation.run_control.Gate`
            then.
        component: The component that a robot needs; None if any robot serves the action.
        holds_base: Whether one such goal at a time has the robot's base for itself.
        outlives_breakdown: Whether its server works on with a base that has broken down, as Nav2's behavior server
            does, which commands a velocity and waits for what comes of it. An empty battery ends it, too.
        exclusive: Whether a goal that does not hold the base preempts the one of this action that runs.
        frames: The frames that a goal refers to.
        flaw: Why no robot could execute a goal, with the code for it or the `Codes.unknown`; None when it is valid.
        not_ready: Why a robot can't take a goal now; None when it can.
        rejects_early: The checks, ``frames`` and ``flaw``, by which Nav2's server rejects a goal from lyrical on; those
            of earlier distributions accept it and abort it.
        skips_frames: Whether *process* skips poses in unknown frames where Nav2's server accepts them.
        order: How scripts ask for it; None when they can't.
        title: Its name for users; empty for its name in words.
        inputs: The fields of a goal that users fill in, by dotted path in the message; None for all a form can show.
        example: A goal that succeeds in the world of the contract tests, in plain values: to make the message here
            would build its model, which takes longer than some commands may.
        example_after: The action whose example must have been done before; None for none.
    """

    name: str
    goal: type[G]
    result: type[R]
    feedback: type[F]
    process: Callable[[Any, G, Report[F]], Generator[Any, Any, R]]
    failure: Callable[[int, str], R]
    codes: Codes
    of_world: bool = False
    component: str | None = None
    holds_base: bool = True
    outlives_breakdown: bool = False
    exclusive: bool = False
    frames: Callable[[G], Iterable[str]] = field(default=lambda _goal: ())
    flaw: Callable[[G], str | Flaw | None] = field(default=lambda _goal: None)
    not_ready: Callable[[Any], str | None] = field(default=lambda _robot: None)
    rejects_early: Set[str] = frozenset()
    skips_frames: bool = False
    order: Order[G] | None = None
    title: str = ""
    inputs: Mapping[str, Input] | None = None
    example: Mapping[str, Any] | None = None
    example_after: str | None = None

    def disabled_by(self, cause: str) -> bool:
        """Return whether its server can't work with a robot that is disabled by a cause, such as ``breakdown``."""
        return self.holds_base and not (self.outlives_breakdown and cause != Cause.BATTERY_EMPTY)

    @cached_property
    def ros_type(self) -> str:
        """The ROS name of the action, such as ``nav2_msgs/action/Wait``."""
        return self.goal.ros_type.removesuffix("_Goal")

    def form(self) -> dict[str, Any]:
        """Return the JSON Schema of the form for a goal, with a title and a description."""
        about = inspect.getmodule(self.process)
        text = inspect.getdoc(about) or "" if about else ""
        described = {"title": self.title or title_of(self.name), "description": text.partition("\n")[0]}
        return {**described, **goal_schema(self.goal, self.inputs)}


AnyAction = Action[Any, Any, Any]


@cache
def registry() -> dict[str, AnyAction]:
    """Return all actions by name."""
    return discover(sys.modules[__name__], "ACTION", Action)


def error_codes(action: AnyAction) -> dict[int, str]:
    """Return the names of the codes that say why the action's server aborts a goal, Nav2's or MoveIt's, by code.

    Nav2's navigators pass on the codes of their planner and their controller.
    """
    passed_on = (_own_codes(registry()[name]) for name in _PASSED_ON.get(action.name, ()))
    return {code: name for codes in (_own_codes(action), *passed_on) for code, name in codes.items()}


def _own_codes(action: AnyAction) -> dict[int, str]:
    code = action.result.model_fields.get("error_code")
    kind = code.annotation if code is not None else None
    source = kind if isinstance(kind, type) and issubclass(kind, Message) else action.result
    named = ((name, getattr(source, name)) for name in dir(source) if name.isupper())
    codes = {value: name for name, value in named if isinstance(value, int) and name not in _NO_ERRORS}
    return dict(sorted(codes.items(), key=lambda entry: abs(entry[0])))


def error_of(result: Message) -> str:
    """Return a result's error message, in the field of Nav2, MoveIt or the simulation; empty if there is none."""
    code, outcome = getattr(result, "error_code", None), getattr(result, "result", None)
    return getattr(result, "error_msg", "") or getattr(code, "message", "") or getattr(outcome, "error_message", "")
