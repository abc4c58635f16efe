"""Drive to a pose along the lanes."""

from __future__ import annotations

from collections.abc import Generator
from functools import cache
from typing import TYPE_CHECKING, Any

from hmrsim.actions import Action, Codes, Order, Report
from hmrsim.actions._inputs import Input, place, pose
from hmrsim.actions._navigation import drive, facing, navigation_of, no_planner, plan
from hmrsim.interfaces.nav2_msgs import NavigateToPose

if TYPE_CHECKING:
    from hmrsim.robots.robot import Robot
    from hmrsim.world.model import World


def _process(
    robot: Robot, goal: NavigateToPose.Goal, report: Report[NavigateToPose.Feedback]
) -> Generator[Any, Any, NavigateToPose.Result]:
    report.sample(navigation_of(robot))
    way = yield from plan(robot, goal.pose)
    yield from drive(robot, way, facing(goal.pose))
    return _done()


@cache
def _done() -> NavigateToPose.Result:
    """Return the result of all goals that succeed."""
    return NavigateToPose.Result()


def _ordered(text: str, world: World) -> NavigateToPose.Goal:
    return NavigateToPose.Goal(pose=pose(*place(text, world)))


ACTION = Action(
    name="navigate_to_pose",
    goal=NavigateToPose.Goal,
    result=NavigateToPose.Result,
    feedback=NavigateToPose.Feedback,
    process=_process,
    failure=lambda code, message: NavigateToPose.Result(error_code=code, error_msg=message),
    codes=Codes.of_nav2(NavigateToPose.Result),
    frames=lambda goal: (goal.pose.header.frame_id,),
    not_ready=no_planner,
    rejects_early={"frames"},
    order=Order("Go", "PLACE, or X Y", _ordered),
    inputs={"pose": Input("Goal pose", required=True)},
    example={"pose": {"pose": {"position": {"x": 10.0, "y": 0.0}}}},
)
