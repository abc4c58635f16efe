"""Drive along a given path, off the lanes if need be."""

from __future__ import annotations

from collections.abc import Generator, Iterator
from functools import cache
from typing import TYPE_CHECKING, Any

from hmrsim.actions import Action, Codes, Flaw, Order, Report
from hmrsim.actions._inputs import Input
from hmrsim.actions._navigation import drive, extent, facing, point_of
from hmrsim.actions._path_tracking import PathTracker
from hmrsim.actions._places import check_reachable, numbers, pose
from hmrsim.diagnostics import shown
from hmrsim.errors import GoalAborted
from hmrsim.geometry import heading
from hmrsim.interfaces.nav2_msgs import FollowPath
from hmrsim.interfaces.nav_msgs import Path

if TYPE_CHECKING:
    from hmrsim.robots.robot import Robot
    from hmrsim.world.model import World


_PLUGINS = {
    "controller": ("FollowPath",),
    "goal checker": ("general_goal_checker", "goal_checker"),
    "progress checker": ("progress_checker",),
}
"""The names of the one plugin of each kind: those of Nav2's parameters, of its trees and of its code. An empty name
stands for the only plugin, as in Nav2's controller_server."""


def _process(
    robot: Robot, goal: FollowPath.Goal, report: Report[FollowPath.Feedback]
) -> Generator[Any, Any, FollowPath.Result]:
    poses = goal.path.poses
    points = [point_of(at) for at in poses]
    for point in points:
        try:
            check_reachable(*point)
        except ValueError as error:
            raise GoalAborted(FollowPath.Result.INVALID_PATH, str(error)) from None
    # The part after an obstacle is not driven, but counts as part of the path.
    beyond = extent(robot, [robot.pose().point, *points])[0] - robot.straight_through(points)[0].length
    # Made when feedback is first wanted.
    tracker = cache(lambda: PathTracker(robot, points))

    def feedback() -> dict[str, Any]:
        speed = abs(robot.velocity()[0])
        left = robot.motion.progress().length + beyond
        return {"distance_to_goal": left, "speed": speed, "tracking_feedback": tracker().values(speed)}

    report.sample(feedback)
    yield from drive(robot, points, facing(poses[-1]))
    return FollowPath.Result()


def _flaw(goal: FollowPath.Goal) -> Flaw | None:
    asked = (
        ("controller", goal.controller_id, FollowPath.Result.INVALID_CONTROLLER),
        ("goal checker", goal.goal_checker_id, FollowPath.Result.UNKNOWN),
        ("progress checker", goal.progress_checker_id, FollowPath.Result.UNKNOWN),
    )
    for kind, name, code in asked:
        if name and name not in _PLUGINS[kind]:
            return Flaw(f"no {kind} {shown(name)}; there is one, called {_PLUGINS[kind][0]}", code)
    return None if goal.path.poses else Flaw("the path has no poses", FollowPath.Result.INVALID_PATH)


def _frames(goal: FollowPath.Goal) -> Iterator[str]:
    yield goal.path.header.frame_id
    yield from (at.header.frame_id for at in goal.path.poses)


def _ordered(text: str, _world: World) -> FollowPath.Goal:
    """Return the path through the points; at each the robot faces the way that it came from the one before."""
    values = numbers(text.split())
    if len(values) % 2 or not values:
        raise ValueError(f"{len(values)} numbers are not points; expected pairs of x and y")
    points = list(zip(values[::2], values[1::2], strict=True))
    for point in points:
        check_reachable(*point)
    before = [points[0], *points]
    yaws = [heading(a, b) for a, b in zip(before, points, strict=False)]
    return FollowPath.Goal(path=Path(poses=[pose(*point, yaw) for point, yaw in zip(points, yaws, strict=True)]))


ACTION = Action(
    name="follow_path",
    goal=FollowPath.Goal,
    result=FollowPath.Result,
    feedback=FollowPath.Feedback,
    process=_process,
    failure=lambda code, message: FollowPath.Result(error_code=code, error_msg=message),
    codes=Codes.of_nav2(FollowPath.Result),
    frames=_frames,
    flaw=_flaw,
    rejects_early={"flaw"},
    order=Order("Follow", "X Y X Y …", _ordered),
    inputs={"path.poses": Input("Path", required=True)},
    example={"path": {"poses": [{"pose": {"position": {"x": 2.0}}}, {"pose": {"position": {"x": 10.0}}}]}},
)
