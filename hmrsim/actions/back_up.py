"""Drive straight back, facing the same way."""

from __future__ import annotations

from collections.abc import Generator
from typing import TYPE_CHECKING, Any

from hmrsim.actions import Action, Codes, Order, Report
from hmrsim.actions._inputs import Input
from hmrsim.actions._maneuvers import distance_ordered, drive_straight, keep_time, travelled_from
from hmrsim.interfaces.nav2_msgs import BackUp

if TYPE_CHECKING:
    from hmrsim.robots.robot import Robot


def _process(robot: Robot, goal: BackUp.Goal, report: Report[BackUp.Feedback]) -> Generator[Any, Any, BackUp.Result]:
    done = keep_time(robot, report, BackUp.Result)
    report.sample(travelled_from(robot))
    # As in Nav2: backwards, for any signs of distance and speed.
    yield from drive_straight(robot, goal, -abs(goal.target.x), BackUp.Result)
    return done()


ACTION = Action(
    name="back_up",
    goal=BackUp.Goal,
    result=BackUp.Result,
    feedback=BackUp.Feedback,
    process=_process,
    outlives_breakdown=True,
    failure=lambda code, message: BackUp.Result(error_code=code, error_msg=message),
    codes=Codes.of_nav2(BackUp.Result),
    order=Order(
        "Back", "DISTANCE [SPEED]", lambda text, world: BackUp.Goal.model_validate(distance_ordered(text, world))
    ),
    inputs={
        "target.x": Input("Distance", "m", default=0.5, minimum=0.0),
        "speed": Input("Speed", "m/s", default=0.25, minimum=0.0),
        "time_allowance": Input("Time allowance, 0 for any", "s", minimum=0.0, advanced=True),
    },
    example={"target": {"x": 1.0}, "speed": 0.5},
)
