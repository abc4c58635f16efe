"""Drive straight ahead, in the direction the robot faces."""

from __future__ import annotations

from collections.abc import Generator
from typing import TYPE_CHECKING, Any

from hmrsim.actions import Action, Codes, Order, Report
from hmrsim.actions._inputs import Input
from hmrsim.actions._maneuvers import distance_ordered, drive_straight, keep_time, travelled_from
from hmrsim.errors import GoalAborted
from hmrsim.interfaces.nav2_msgs import DriveOnHeading

if TYPE_CHECKING:
    from hmrsim.robots.robot import Robot


def _process(
    robot: Robot, goal: DriveOnHeading.Goal, report: Report[DriveOnHeading.Feedback]
) -> Generator[Any, Any, DriveOnHeading.Result]:
    done = keep_time(robot, report, DriveOnHeading.Result)
    report.sample(travelled_from(robot))
    if goal.target.x * goal.speed < 0:
        text = f"the signs of distance {goal.target.x:g} and speed {goal.speed:g} differ; give both the same"
        raise GoalAborted(DriveOnHeading.Result.INVALID_INPUT, text)
    yield from drive_straight(robot, goal, goal.target.x, DriveOnHeading.Result)
    return done()


ACTION = Action(
    name="drive_on_heading",
    goal=DriveOnHeading.Goal,
    result=DriveOnHeading.Result,
    feedback=DriveOnHeading.Feedback,
    process=_process,
    outlives_breakdown=True,
    failure=lambda code, message: DriveOnHeading.Result(error_code=code, error_msg=message),
    codes=Codes.of_nav2(DriveOnHeading.Result),
    order=Order(
        "Drive",
        "DISTANCE [SPEED]",
        lambda text, world: DriveOnHeading.Goal.model_validate(distance_ordered(text, world)),
    ),
    inputs={
        "target.x": Input("Distance", "m", default=0.5),
        "speed": Input("Speed, with the sign of the distance", "m/s", default=0.25),
        "time_allowance": Input("Time allowance, 0 for any", "s", minimum=0.0, advanced=True),
    },
    example={"target": {"x": 1.0}, "speed": 0.5},
)
