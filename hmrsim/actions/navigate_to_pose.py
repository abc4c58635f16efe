"""Drive to a pose along the lanes."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

from hmrsim.actions import Action, Codes, Order, Report
from hmrsim.actions._places import place, pose
from hmrsim.geometry import yaw_of
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS, values_of
from hmrsim.interfaces.nav2_msgs import NavigateToPose

if TYPE_CHECKING:
    from collections.abc import Generator

    from hmrsim.robot import Robot
    from hmrsim.world.model import World


def _process(
    robot: Robot, goal: NavigateToPose.Goal, report: Report[NavigateToPose.Feedback]
) -> Generator[Any, Any, NavigateToPose.Result]:
    target = goal.pose.pose
    began = robot.now
    report.sample(lambda: _feedback(robot, began))
    route = robot.plan_to((target.position.x, target.position.y))
    yield from robot.drive(route, yaw_of(target.orientation.z, target.orientation.w))
    return _done()


@cache
def _done() -> NavigateToPose.Result:
    """Return the result of all goals that succeed."""
    return NavigateToPose.Result()


def _feedback(robot: Robot, began: float) -> dict[str, Any]:
    """Return the feedback in plain values: it is made more often than anything else."""
    pose, length, seconds = robot.progress()
    return {
        "current_pose": robot.stamped(pose),
        "navigation_time": values_of((robot.now - began) * NANOSECONDS),
        "estimated_time_remaining": values_of(seconds * NANOSECONDS),
        "number_of_recoveries": 0,
        "distance_remaining": length,
    }


def _not_ready(robot: Robot) -> str | None:
    if robot.planner == "external":
        return f"{robot.name} has an external planner, and none has announced itself"
    return None


def _ordered(text: str, world: World) -> NavigateToPose.Goal:
    return NavigateToPose.Goal(pose=pose(*place(text, world)))


ACTION = Action(
    name="navigate_to_pose",
    ros_type="nav2_msgs/action/NavigateToPose",
    goal=NavigateToPose.Goal,
    result=NavigateToPose.Result,
    feedback=NavigateToPose.Feedback,
    process=_process,
    failure=lambda code, message: NavigateToPose.Result(error_code=code, error_msg=message),
    codes=Codes(canceled=0, preempted=NavigateToPose.Result.UNKNOWN, rejected=1, unknown=NavigateToPose.Result.UNKNOWN),
    frames=lambda goal: (goal.pose.header.frame_id,),
    not_ready=_not_ready,
    order=Order("Go", "PLACE, or X Y", _ordered),
    example={"pose": {"pose": {"position": {"x": 10.0, "y": 0.0}}}},
)
