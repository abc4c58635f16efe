"""Stand still for a while."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from hmrsim.actions import Action, Codes, Report
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.nav2_msgs import Wait

if TYPE_CHECKING:
    from collections.abc import Generator

    from hmrsim.robot import Robot


def _process(robot: Robot, goal: Wait.Goal, report: Report[Wait.Feedback]) -> Generator[Any, Any, Wait.Result]:
    seconds = max(0.0, goal.time.to_seconds())
    until = robot.now + seconds
    report.sample(lambda: Wait.Feedback(time_left=Duration.from_seconds(max(0.0, until - robot.now))))
    yield from robot.hold(seconds)
    return Wait.Result(total_elapsed_time=Duration.from_seconds(seconds))


ACTION = Action(
    name="wait",
    ros_type="nav2_msgs/action/Wait",
    goal=Wait.Goal,
    result=Wait.Result,
    feedback=Wait.Feedback,
    process=_process,
    failure=lambda code, message: Wait.Result(error_code=code, error_msg=message),
    codes=Codes(canceled=0, preempted=Wait.Result.UNKNOWN, rejected=1, unknown=Wait.Result.UNKNOWN),
    example=Wait.Goal(time=Duration(sec=2)),
)
