"""Plan a path along the lanes without driving it."""

from __future__ import annotations

from collections.abc import Generator
from typing import TYPE_CHECKING, Any

from hmrsim.actions import Action, Codes, Report
from hmrsim.actions._inputs import Input
from hmrsim.actions._navigation import facing, path_message, planner_flaw, point_of, poses_along
from hmrsim.interfaces.nav2_msgs import ComputePathToPose

if TYPE_CHECKING:
    from hmrsim.robots.robot import Robot


def _process(
    robot: Robot, goal: ComputePathToPose.Goal, _report: Report[ComputePathToPose.Feedback]
) -> Generator[Any, Any, ComputePathToPose.Result]:
    yield from ()
    start = point_of(goal.start) if goal.use_start else robot.pose().point
    route = robot.plan_to(point_of(goal.goal), start)
    return ComputePathToPose.Result(path=path_message(robot, [*poses_along(route, start, facing(goal.goal))]))


ACTION = Action(
    name="compute_path_to_pose",
    goal=ComputePathToPose.Goal,
    result=ComputePathToPose.Result,
    feedback=ComputePathToPose.Feedback,
    process=_process,
    failure=lambda code, message: ComputePathToPose.Result(error_code=code, error_msg=message),
    codes=Codes.of_nav2(ComputePathToPose.Result),
    flaw=lambda goal: planner_flaw(goal.planner_id, ComputePathToPose.Result.INVALID_PLANNER),
    rejects_early={"flaw"},
    holds_base=False,
    frames=lambda goal: (goal.goal.header.frame_id, goal.start.header.frame_id if goal.use_start else ""),
    inputs={"goal": Input("Goal pose", required=True)},
    example={"goal": {"pose": {"position": {"x": 10.0, "y": 0.0}}}},
)
