"""The verbs of a robot: each makes the goal of one action from places, meters, radians and seconds.

`Commander` and `AsyncRobot` make their methods of them. Names follow the actions, and Nav2's ``BasicNavigator`` where
it has a method for the action.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import update_wrapper
from numbers import Real
from typing import TYPE_CHECKING, Any, Concatenate, Final, Generic, ParamSpec, TypeVar

from pydantic import ValidationError

from hmrsim.actions import error_of, registry
from hmrsim.diagnostics import instead, shown
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.geometry_msgs import Point
from hmrsim.interfaces.message import Message
from hmrsim.interfaces.moveit_msgs import Pickup, Place
from hmrsim.interfaces.nav2_msgs import (
    BackUp,
    ComputeAndTrackRoute,
    ComputePathThroughPoses,
    ComputePathToPose,
    ComputeRoute,
    DockRobot,
    DriveOnHeading,
    FollowPath,
    FollowWaypoints,
    NavigateThroughPoses,
    NavigateToPose,
    SmoothPath,
    Spin,
    UndockRobot,
    Wait,
)
from hmrsim.interfaces.nav_msgs import Goals
from hmrsim.program.users_code import field_errors
from hmrsim.protocol.goal import GoalStatus
from hmrsim_zenoh.client.places import with_poses
from hmrsim_zenoh.errors import GoalFailed

if TYPE_CHECKING:
    from hmrsim.actions import AnyAction
    from hmrsim.interfaces.geometry_msgs import PoseStamped
    from hmrsim.interfaces.nav_msgs import Path
    from hmrsim_zenoh.client.goal_handle import GoalHandle
    from hmrsim_zenoh.client.places import NamedPlaces, Target

P = ParamSpec("P")
R = TypeVar("R", bound=Message)
F = TypeVar("F", bound=Message)

OnFeedback = Callable[[F], object] | None
"""Called with each feedback of a goal; None to not subscribe to feedback."""


@dataclass(frozen=True)
class Request(Generic[R]):
    """A goal to send, and the type of its result.

    Attributes:
        action: The action, or its name.
        goal: The goal, or its plain values.
        result: The type of its result.
        on_feedback: Called with each feedback.
    """

    action: AnyAction | str
    goal: Message | Mapping[str, Any]
    result: type[R]
    on_feedback: OnFeedback[Any] = None

    @property
    def definition(self) -> AnyAction:
        """The definition of the action.

        Raises:
            ValueError: No action of this name is installed.
        """
        if not isinstance(self.action, str):
            return self.action
        actions = registry()
        if self.action not in actions:
            raise ValueError(f"no action {shown(self.action)} is installed{instead(self.action, actions)}")
        return actions[self.action]

    def result_of(self, robot: str, handle: GoalHandle[Any, Any]) -> R:
        """Return the result of a goal that is done and was sent to *robot*.

        Raises:
            GoalFailed: The goal was aborted or canceled.
            HmrsimError: The goal was rejected, or there is no answer; as `GoalHandle.result`.
        """
        result = handle.result()
        name = self.definition.name
        if not isinstance(result, self.result):
            raise TypeError(f"{name} gave {result!r}")
        if handle.status is not GoalStatus.SUCCEEDED:
            text = f"{robot}: {name} ended {handle.status.name}: {_reason(result)}"
            raise GoalFailed(text, handle.status, result, handle.cause)
        return result


def _reason(result: Message) -> str:
    """Return the error message and code of a result; Nav2 and MoveIt have them in different fields."""
    code, text = getattr(result, "error_code", None), error_of(result)
    number = getattr(code, "val", code)
    return f"{text} ({number})" if text else f"error code {number}"


_SELF: Final = inspect.Parameter("self", inspect.Parameter.POSITIONAL_ONLY)


def requested(
    verb: Callable[Concatenate[NamedPlaces, P], Request[R]], places: NamedPlaces, *args: P.args, **kwargs: P.kwargs
) -> Request[R]:
    """Return what a verb requests.

    Raises:
        ValueError: A value is invalid, or there is no place of a name; one line per value.
        TypeError: A target is none.
    """
    try:
        return verb(places, *args, **kwargs)
    except ValidationError as error:
        raise ValueError("\n".join(f"{verb.__name__}: {each}" for each in field_errors(error))) from None


def present_as(verb: Callable[..., Any], method: Callable[..., Any]) -> None:
    """Give a method the name, documentation and signature of its verb, with ``self`` in place of the places."""
    update_wrapper(method, verb)
    signature = inspect.signature(verb)
    _places, *parameters = signature.parameters.values()
    result = signature.return_annotation.removeprefix("Request[").removesuffix("]")
    vars(method)["__signature__"] = signature.replace(parameters=[_SELF, *parameters], return_annotation=result)


def navigate_to(
    places: NamedPlaces, target: Target, *, on_feedback: OnFeedback[NavigateToPose.Feedback] = None
) -> Request[NavigateToPose.Result]:
    """Drive to a place or a pose."""
    goal = NavigateToPose.Goal(pose=places.pose(target))
    return Request("navigate_to_pose", goal, NavigateToPose.Result, on_feedback)


def navigate_through(
    places: NamedPlaces, targets: Sequence[Target], *, on_feedback: OnFeedback[NavigateThroughPoses.Feedback] = None
) -> Request[NavigateThroughPoses.Result]:
    """Drive to the last of some places by way of the others."""
    goal = NavigateThroughPoses.Goal(poses=_goals(places, targets))
    return Request("navigate_through_poses", goal, NavigateThroughPoses.Result, on_feedback)


def follow_waypoints(
    places: NamedPlaces,
    targets: Sequence[Target],
    *,
    loops: int = 0,
    on_feedback: OnFeedback[FollowWaypoints.Feedback] = None,
) -> Request[FollowWaypoints.Result]:
    """Visit places one after the other, and repeat that *loops* times; the result lists the places that were missed."""
    goal = FollowWaypoints.Goal(poses=_poses(places, targets), number_of_loops=loops)
    return Request("follow_waypoints", goal, FollowWaypoints.Result, on_feedback)


def compute_path_to(
    places: NamedPlaces, target: Target, start: Target | None = None
) -> Request[ComputePathToPose.Result]:
    """Plan a path to a place, from the robot or from *start*."""
    goal = ComputePathToPose.Goal(goal=places.pose(target), **_start(places, start))
    return Request("compute_path_to_pose", goal, ComputePathToPose.Result)


def compute_path_through(
    places: NamedPlaces, targets: Sequence[Target], start: Target | None = None
) -> Request[ComputePathThroughPoses.Result]:
    """Plan a path through places, from the robot or from *start*."""
    goal = ComputePathThroughPoses.Goal(goals=_goals(places, targets), **_start(places, start))
    return Request("compute_path_through_poses", goal, ComputePathThroughPoses.Result)


def compute_route(places: NamedPlaces, target: Target, start: Target | None = None) -> Request[ComputeRoute.Result]:
    """Plan a route along lanes, from the robot or from *start*."""
    goal = ComputeRoute.Goal(goal=places.pose(target), use_poses=True, **_start(places, start))
    return Request("compute_route", goal, ComputeRoute.Result)


def track_route(
    places: NamedPlaces, target: Target, *, on_feedback: OnFeedback[ComputeAndTrackRoute.Feedback] = None
) -> Request[ComputeAndTrackRoute.Result]:
    """Plan a route along lanes, and report the robot's progress until it reaches the end, however it is driven."""
    goal = ComputeAndTrackRoute.Goal(goal=places.pose(target), use_poses=True)
    return Request("compute_and_track_route", goal, ComputeAndTrackRoute.Result, on_feedback)


def follow_path(
    _places: NamedPlaces, path: Path, *, on_feedback: OnFeedback[FollowPath.Feedback] = None
) -> Request[FollowPath.Result]:
    """Drive along a path, such as ``compute_path_to(…).path``."""
    return Request("follow_path", FollowPath.Goal(path=path), FollowPath.Result, on_feedback)


def smooth_path(_places: NamedPlaces, path: Path) -> Request[SmoothPath.Result]:
    """Smooth a path without driving along it."""
    return Request("smooth_path", SmoothPath.Goal(path=path), SmoothPath.Result)


def spin(_places: NamedPlaces, yaw: float, *, on_feedback: OnFeedback[Spin.Feedback] = None) -> Request[Spin.Result]:
    """Turn on the spot by *yaw* radians, to the left if it is positive."""
    return Request("spin", Spin.Goal(target_yaw=yaw), Spin.Result, on_feedback)


def back_up(
    _places: NamedPlaces, distance: float, speed: float, *, on_feedback: OnFeedback[BackUp.Feedback] = None
) -> Request[BackUp.Result]:
    """Drive straight back by a distance, at a speed."""
    return Request("back_up", BackUp.Goal(target=Point(x=distance), speed=speed), BackUp.Result, on_feedback)


def drive_on_heading(
    _places: NamedPlaces, distance: float, speed: float, *, on_feedback: OnFeedback[DriveOnHeading.Feedback] = None
) -> Request[DriveOnHeading.Result]:
    """Drive straight ahead by a distance, at a speed."""
    goal = DriveOnHeading.Goal(target=Point(x=distance), speed=speed)
    return Request("drive_on_heading", goal, DriveOnHeading.Result, on_feedback)


def dock(
    _places: NamedPlaces, dock: str, *, navigate: bool = True, on_feedback: OnFeedback[DockRobot.Feedback] = None
) -> Request[DockRobot.Result]:
    """Dock at a dock; first drive to its staging pose if *navigate*."""
    goal = DockRobot.Goal(dock_id=dock, navigate_to_staging_pose=navigate)
    return Request("dock_robot", goal, DockRobot.Result, on_feedback)


def undock(
    _places: NamedPlaces, *, on_feedback: OnFeedback[UndockRobot.Feedback] = None
) -> Request[UndockRobot.Result]:
    """Leave the dock that the robot is in."""
    return Request("undock_robot", UndockRobot.Goal(), UndockRobot.Result, on_feedback)


def pickup(
    _places: NamedPlaces, name: str, *, on_feedback: OnFeedback[Pickup.Feedback] = None
) -> Request[Pickup.Result]:
    """Pick up an item within reach."""
    return Request("pickup", Pickup.Goal(target_name=name), Pickup.Result, on_feedback)


def place(_places: NamedPlaces, name: str, *, on_feedback: OnFeedback[Place.Feedback] = None) -> Request[Place.Result]:
    """Put down an item that the robot holds."""
    return Request("place", Place.Goal(attached_object_name=name), Place.Result, on_feedback)


def wait(
    _places: NamedPlaces, seconds: float, *, on_feedback: OnFeedback[Wait.Feedback] = None
) -> Request[Wait.Result]:
    """Stand still for *seconds* of simulated time, which may be zero but not negative."""
    if not isinstance(seconds, Real) or not seconds >= 0:
        raise ValueError(f"wait: seconds: expected a number that is at least 0, got {shown(seconds)}")
    return Request("wait", Wait.Goal(time=Duration.from_seconds(seconds)), Wait.Result, on_feedback)


def do(  # noqa: D417 - the methods have no *places*
    places: NamedPlaces,
    action: AnyAction | str,
    goal: Message | Mapping[str, Any],
    *,
    on_feedback: OnFeedback[Any] = None,
) -> Request[Any]:
    """Send a goal of any action, such as one of a plug-in: ``mocha.do("wipe", {"strokes": 4})``.

    Args:
        action: The action, or its name.
        goal: The goal, or its plain values; missing fields have their defaults, and a pose may be the name of a place
            or a list or tuple of x, y and optionally yaw.
        on_feedback: Called with each feedback.

    Raises:
        ValueError: No action of this name is installed here, or a place does not exist.
        RequestError: The simulator does not serve the action, or the goal has other fields.
    """
    request = Request(action, goal, Message, on_feedback)
    if isinstance(goal, Message):
        return request
    values = with_poses(goal, request.definition.goal, places.pose)
    return Request(action, values, Message, on_feedback)


def _goals(places: NamedPlaces, targets: Sequence[Target]) -> Goals:
    return Goals(goals=_poses(places, targets))


def _poses(places: NamedPlaces, targets: Sequence[Target]) -> list[PoseStamped]:
    if isinstance(targets, str) or not isinstance(targets, Iterable):
        raise TypeError(f"targets: expected a list of targets, got {shown(targets)}")
    return [places.pose(target, f"targets[{at}]") for at, target in enumerate(targets)]


def _start(places: NamedPlaces, start: Target | None) -> dict[str, Any]:
    return {} if start is None else {"start": places.pose(start, "start"), "use_start": True}
