"""Plan a path along the lanes without driving it."""

from __future__ import annotations

from collections.abc import Generator
from typing import TYPE_CHECKING, Any

from hmrsim.actions import Action, Codes, Report
from hmrsim.actions._inputs import Input
from hmrsim.actions._navigation import facing, point_of
from hmrsim.geometry import Pose
from hmrsim.interfaces.nav2_msgs import ComputePathToPose
from hmrsim.interfaces.nav_msgs import Path

if TYPE_CHECKING:
    from hmrsim.robots.robot import Robot

_PLANNERS = ("", "graph", "GridBased")
"""Names of the one planner that there is: none, that of world files, and the one that Nav2's own trees ask for."""


def _process(
    robot: Robot, goal: ComputePathToPose.Goal, _report: Report[ComputePathToPose.Feedback]
) -> Generator[Any, Any, ComputePathToPose.Result]:
    yield from ()
    start = point_of(goal.start) if goal.use_start else robot.pose().point
    route = robot.plan_to(point_of(goal.goal), start)
    end = route.legs[-1].end if route.legs else start
    poses = [*(leg.first for leg in route.legs), Pose(*end, facing(goal.goal))]
    stamped = [robot.stamped(pose) for pose in poses]
    # Planning takes no simulated time.
    path = Path.model_validate({"header": stamped[0]["header"], "poses": stamped})
    return ComputePathToPose.Result(path=path)


def _flaw(goal: ComputePathToPose.Goal) -> str | None:
    if goal.planner_id in _PLANNERS:
        return None
    return f"no planner {goal.planner_id!r}; there is one, called {', '.join(filter(None, _PLANNERS))}"


ACTION = Action(
    name="compute_path_to_pose",
    goal=ComputePathToPose.Goal,
    result=ComputePathToPose.Result,
    feedback=ComputePathToPose.Feedback,
    process=_process,
    failure=lambda code, message: ComputePathToPose.Result(error_code=code, error_msg=message),
    codes=Codes.of_nav2(ComputePathToPose.Result),
    flaw=_flaw,
    holds_base=False,
    frames=lambda goal: (goal.goal.header.frame_id, goal.start.header.frame_id if goal.use_start else ""),
    inputs={"goal": Input("Goal pose", required=True)},
    example={"goal": {"pose": {"position": {"x": 10.0, "y": 0.0}}}},
)
