"""The parts that navigation actions share: planning, driving, feedback and path messages.

A robot either plans on the lanes of the world, or asks an external planner. In that case it drives straight from pose
to pose of the planned path, and uses no lanes.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from hmrsim.actions import FRAMES, Flaw
from hmrsim.errors import GoalAborted
from hmrsim.geometry import Pose, distance, yaw_of
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS, values_of
from hmrsim.interfaces.nav2_msgs import ComputePathToPose, FollowPath
from hmrsim.interfaces.nav_msgs import Path
from hmrsim.navigation.route import Route
from hmrsim.protocol.goal import Cause

if TYPE_CHECKING:
    from collections.abc import Iterator

    from hmrsim.geometry import Point
    from hmrsim.interfaces.geometry_msgs import PoseStamped
    from hmrsim.robots.robot import Robot


if TYPE_CHECKING:
    Way = Route | Sequence[Point]
    """A route along the lanes, or points to drive to in straight lines."""


def point_of(pose: PoseStamped) -> Point:
    """Return the point of a pose."""
    return pose.pose.position.x, pose.pose.position.y


def facing(pose: PoseStamped) -> float:
    """Return the yaw of a pose, in radians."""
    return yaw_of(pose.pose.orientation.z, pose.pose.orientation.w)


def no_planner(robot: Robot) -> str | None:
    """Return why a robot can't accept a goal that needs planning now; None if it can."""
    if robot.planner == "external" and not robot.plans.present:
        return f"{robot.name} has an external planner, and none has announced itself"
    return None


def plan(robot: Robot, goal: PoseStamped, start: PoseStamped | None = None) -> Generator[Any, Any, Way]:
    """Return the route to a pose, from the robot's pose or from another one.

    Raises:
        GoalAborted: There is no route; the code is that of ComputePathToPose.
    """
    if robot.planner != "external":
        return robot.plan_to(point_of(goal), point_of(start) if start else None)
    request = ComputePathToPose.Goal(goal=goal, start=start or robot.pose_stamped(), use_start=True)
    result: ComputePathToPose.Result = yield from robot.plans.ask(robot.name, request)
    if result.error_code:
        raise GoalAborted(result.error_code, result.error_msg or f"the planner gave code {result.error_code}")
    path = result.path
    if not path.poses:
        raise GoalAborted(ComputePathToPose.Result.NO_VALID_PATH, "the planner gave a path without poses")
    for frame in (path.header.frame_id, *(pose.header.frame_id for pose in path.poses)):
        if frame not in FRAMES:
            text = f"the planner's path is in the unknown frame {frame!r}; use 'map' or leave it empty"
            raise GoalAborted(ComputePathToPose.Result.TF_ERROR, text)
    return [point_of(pose) for pose in path.poses]


def drive(robot: Robot, way: Way, final_yaw: float | None) -> Generator[Any, Any, None]:
    """Drive a robot along a route or straight to points, then turn it to *final_yaw*, unless that is None.

    Raises:
        GoalAborted: The robot has stopped in front of an obstacle, or can't continue for another reason.
    """
    route, blocked = (way, "") if isinstance(way, Route) else robot.straight_through(way)
    yield from robot.drive(route, None if blocked else final_yaw)
    if blocked:
        raise GoalAborted(FollowPath.Result.NO_VALID_CONTROL, f"blocked: {blocked}", Cause.BLOCKED)


def extent(robot: Robot, way: Way) -> tuple[float, float]:
    """Return the length of a way, and the seconds that a robot needs for it if nothing obstructs it."""
    if isinstance(way, Route):
        return way.length, sum(leg.seconds(robot.speed) for leg in way.legs)
    total = sum(distance(a, b) for a, b in pairwise(way))
    return total, total / robot.speed


def _nothing() -> tuple[float, float]:
    return 0.0, 0.0


def navigation_of(robot: Robot, ahead: Callable[[], tuple[float, float]] = _nothing) -> Callable[[], dict[str, Any]]:
    """Return the function that samples the feedback of a robot that sets out now.

    The feedback is plain values, since it is more frequent than any other. *ahead* returns the length and the seconds
    of the routes after the current one.
    """
    began, recoveries = robot.now, robot.recoveries

    def feedback() -> dict[str, Any]:
        pose, remaining, seconds = robot.motion.progress()
        remaining_ahead, seconds_ahead = ahead()
        return {
            "current_pose": robot.stamped(robot.estimated(pose)),
            "navigation_time": values_of((robot.now - began) * NANOSECONDS),
            "estimated_time_remaining": values_of((seconds + seconds_ahead) * NANOSECONDS),
            "number_of_recoveries": robot.recoveries - recoveries,
            "distance_remaining": remaining + remaining_ahead,
        }

    return feedback


_PLANNERS = ("", "graph", "GridBased")
"""The names of the only planner: the empty default, the name in world files, and that in Nav2's behavior trees."""


def planner_flaw(planner_id: str, code: int) -> Flaw | None:
    """Return the flaw of an unknown planner, with the error *code* for that; None if the planner is known."""
    if planner_id in _PLANNERS:
        return None
    return Flaw(f"no planner {planner_id!r}; there is one, called {', '.join(filter(None, _PLANNERS))}", code)


def poses_along(route: Route, start: Point, yaw: float) -> Iterator[Pose]:
    """Yield the pose at the start of each leg, facing along it, then the end with a *yaw*.

    The end of a route without legs is *start*.
    """
    yield from (leg.first for leg in route.legs)
    end = route.legs[-1].end if route.legs else start
    yield Pose(*end, yaw)


def path_values(robot: Robot, poses: Sequence[Pose]) -> dict[str, Any]:
    """Return the plain values of a path through one or more poses, stamped with the current time."""
    stamped = [robot.stamped(pose) for pose in poses]
    return {"header": stamped[0]["header"], "poses": stamped}


def path_message(robot: Robot, poses: Sequence[Pose]) -> Path:
    """Return a path through one or more poses, stamped with the current time."""
    return Path.model_validate(path_values(robot, poses))
