"""Plan a path along the lanes through several poses without driving it."""

from __future__ import annotations

from collections.abc import Generator, Iterator
from typing import TYPE_CHECKING, Any

from hmrsim.actions import Action, Codes, Report
from hmrsim.actions._inputs import Input
from hmrsim.actions._navigation import facing, path_message, planner_flaw, point_of, poses_along
from hmrsim.errors import GoalAborted, NoRoute
from hmrsim.interfaces.nav2_msgs import ComputePathThroughPoses, ComputePathToPose

if TYPE_CHECKING:
    from hmrsim.geometry import Pose
    from hmrsim.robots.robot import Robot

_CODES = ComputePathThroughPoses.Result
_OFFSET = _CODES.UNKNOWN - ComputePathToPose.Result.UNKNOWN
"""The difference between the error codes of this action and those of ``compute_path_to_pose`` for the same errors."""


def _process(
    robot: Robot, goal: ComputePathThroughPoses.Goal, _report: Report[ComputePathThroughPoses.Feedback]
) -> Generator[Any, Any, ComputePathThroughPoses.Result]:
    yield from ()
    goals = goal.goals.goals
    if not goals:
        raise GoalAborted(_CODES.NO_VIAPOINTS_GIVEN, "there are no poses; give one at least")
    here = point_of(goal.start) if goal.use_start else robot.pose().point
    poses: list[Pose] = []
    for number, target in enumerate(goals):
        try:
            route = robot.plan_to(point_of(target), here)
        except NoRoute as error:
            raise GoalAborted(error.code + _OFFSET, f"pose {number}: {error}", error.cause) from None
        section = [*poses_along(route, here, facing(target))]
        # Two sections share the pose where they meet, as in the paths that Nav2's planner server joins.
        if poses and route.legs:
            poses += section[1:]
        else:
            poses[-1:] = section
        here = poses[-1].point
    return ComputePathThroughPoses.Result(path=path_message(robot, poses))


def _frames(goal: ComputePathThroughPoses.Goal) -> Iterator[str]:
    yield goal.goals.header.frame_id
    yield from (pose.header.frame_id for pose in goal.goals.goals)
    if goal.use_start:
        yield goal.start.header.frame_id


ACTION = Action(
    name="compute_path_through_poses",
    goal=ComputePathThroughPoses.Goal,
    result=ComputePathThroughPoses.Result,
    feedback=ComputePathThroughPoses.Feedback,
    process=_process,
    failure=lambda code, message: ComputePathThroughPoses.Result(error_code=code, error_msg=message),
    codes=Codes.of_nav2(ComputePathThroughPoses.Result),
    flaw=lambda goal: planner_flaw(goal.planner_id, ComputePathThroughPoses.Result.INVALID_PLANNER),
    rejects_early={"flaw"},
    holds_base=False,
    frames=_frames,
    inputs={"goals.goals": Input("Poses", required=True)},
    example={"goals": {"goals": [{"pose": {"position": {"x": 4.0}}}, {"pose": {"position": {"x": 10.0}}}]}},
)
