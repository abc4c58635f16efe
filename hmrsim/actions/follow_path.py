"""Drive along a given path, off the lanes if need be."""

from __future__ import annotations

import math
from collections.abc import Generator, Iterator
from functools import cache
from itertools import accumulate, pairwise
from typing import TYPE_CHECKING, Any, Final

from hmrsim.actions import Action, Codes, Flaw, Order, Report
from hmrsim.actions._inputs import Input, check_reachable, numbers, pose
from hmrsim.actions._navigation import drive, extent, facing, point_of
from hmrsim.diagnostics import shown
from hmrsim.errors import GoalAborted
from hmrsim.geometry import METER, distance, foot, heading, turn
from hmrsim.interfaces.nav2_msgs import FollowPath
from hmrsim.interfaces.nav_msgs import Path

if TYPE_CHECKING:
    from collections.abc import Sequence

    from hmrsim.geometry import Point
    from hmrsim.robots.robot import Robot
    from hmrsim.world.model import World


_WINDOW: Final = 2.0
"""How far ahead on the path its nearest point is looked for, beside what the robot may have driven since, in meters."""


class PathTracker:
    """The progress of a robot along a path.

    Args:
        points: Those of the path, of which there is one at least.
    """

    def __init__(self, robot: Robot, points: Sequence[Point]) -> None:
        self._robot = robot
        self._segments = list(pairwise(points)) or [(points[0], points[0])]
        lengths = [distance(a, b) for a, b in self._segments]
        self._driven = [0.0, *accumulate(lengths)]
        self._at = 0
        self._along = 0.0
        self._looked = -math.inf

    def values(self, speed: float) -> dict[str, Any]:
        """Return the plain values of a nav2_msgs/msg/TrackingFeedback."""
        robot = self._robot
        pose = robot.estimated(robot.pose())
        error = self._approach(pose.point)
        a, b = self._segments[self._at]
        stamped = robot.stamped(pose)
        return {
            "header": stamped["header"],
            "position_tracking_error": error,
            "heading_tracking_error": turn(pose.yaw, heading(a, b)) if a != b else 0.0,
            "current_path_index": self._at,
            "robot_pose": stamped,
            "distance_to_goal": distance(pose.point, self._segments[-1][1]),
            "speed": speed,
            "remaining_path_length": self._driven[-1] - self._along,
        }

    def _approach(self, point: Point) -> float:
        """Go on to the point of the path nearest to another one; return how far left of the path that is."""
        window = _WINDOW * METER[self._robot.units] + self._robot.speed * (self._robot.now - self._looked)
        self._looked = self._robot.now
        begin, best = self._along, math.inf
        for number in range(self._at, len(self._segments)):
            if self._driven[number] - begin > window:
                break
            a, b = self._segments[number]
            near = foot(point, a, b)
            away = distance(point, near)
            if away < best:
                best, self._along, self._at = away, self._driven[number] + distance(a, near), number
        a, b = self._segments[self._at]
        left = (b[0] - a[0]) * (point[1] - a[1]) - (b[1] - a[1]) * (point[0] - a[0])
        return best if left >= 0.0 else -best


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
