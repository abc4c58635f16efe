"""Smooth a path: at this level a robot turns on the spot, so corners stay, and poses face the way that goes on."""

from __future__ import annotations

from collections.abc import Generator, Iterator
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from hmrsim.actions import Action, Codes, Flaw, Report
from hmrsim.actions._inputs import Input, check_reachable
from hmrsim.actions._navigation import facing, path_message, point_of
from hmrsim.errors import GoalAborted
from hmrsim.geometry import SAME_PLACE, Pose, distance, heading
from hmrsim.interfaces.nav2_msgs import SmoothPath

if TYPE_CHECKING:
    from hmrsim.interfaces.nav_msgs import Path
    from hmrsim.robots.robot import Robot

_SMOOTHERS = ("", "simple_smoother", "route_smoother")
"""Names of the one smoother that there is: none, and those of Nav2's own configuration."""


def _process(
    robot: Robot, goal: SmoothPath.Goal, _report: Report[SmoothPath.Feedback]
) -> Generator[Any, Any, SmoothPath.Result]:
    yield from ()
    for at in goal.path.poses:
        try:
            check_reachable(*point_of(at))
        except ValueError as error:
            raise GoalAborted(SmoothPath.Result.INVALID_PATH, str(error)) from None
    poses = _smoothed(goal.path)
    if goal.check_for_collisions:
        _, blocked = robot.graph.straight_through([pose.point for pose in poses], flies=robot.flies)
        if blocked:
            raise GoalAborted(SmoothPath.Result.SMOOTHED_PATH_IN_COLLISION, f"blocked: {blocked}")
    return SmoothPath.Result(path=path_message(robot, poses), was_completed=True)


def _smoothed(path: Path) -> list[Pose]:
    """Return the poses of a path without those that repeat a place, each facing the next; the last one as it was."""
    points = [point_of(path.poses[0])]
    for at in path.poses:
        if distance(points[-1], point_of(at)) > SAME_PLACE:
            points.append(point_of(at))
    return [*(Pose(*a, heading(a, b)) for a, b in pairwise(points)), Pose(*points[-1], facing(path.poses[-1]))]


def _flaw(goal: SmoothPath.Goal) -> Flaw | None:
    if goal.smoother_id not in _SMOOTHERS:
        text = f"no smoother {goal.smoother_id!r}; there is one, called {', '.join(filter(None, _SMOOTHERS))}"
        return Flaw(text, SmoothPath.Result.INVALID_SMOOTHER)
    return None if goal.path.poses else Flaw("the path has no poses", SmoothPath.Result.INVALID_PATH)


def _frames(goal: SmoothPath.Goal) -> Iterator[str]:
    yield goal.path.header.frame_id
    yield from (at.header.frame_id for at in goal.path.poses)


ACTION = Action(
    name="smooth_path",
    goal=SmoothPath.Goal,
    result=SmoothPath.Result,
    feedback=SmoothPath.Feedback,
    process=_process,
    failure=lambda code, message: SmoothPath.Result(error_code=code, error_msg=message),
    codes=Codes.of_nav2(SmoothPath.Result),
    holds_base=False,
    frames=_frames,
    flaw=_flaw,
    rejects_early={"flaw"},
    inputs={"path.poses": Input("Path", required=True)},
    example={"path": {"poses": [{"pose": {"position": {"x": 2.0}}}, {"pose": {"position": {"x": 10.0}}}]}},
)
