"""Turn a robot on the spot."""

from __future__ import annotations

from collections.abc import Generator
from typing import TYPE_CHECKING, Any

from hmrsim.actions import Action, Codes, Order, Report
from hmrsim.actions._inputs import Input, numbers
from hmrsim.actions._maneuvers import keep_time, perform
from hmrsim.interfaces.nav2_msgs import Spin
from hmrsim.navigation import motion

if TYPE_CHECKING:
    from hmrsim.navigation.motion import Piece
    from hmrsim.robots.robot import Robot
    from hmrsim.world.model import World


def _process(robot: Robot, goal: Spin.Goal, report: Report[Spin.Feedback]) -> Generator[Any, Any, Spin.Result]:
    done = keep_time(robot, report, Spin.Result)
    start = robot.pose()
    report.sample(lambda: {"angular_distance_traveled": robot.pose().yaw - start.yaw})

    def rest() -> Piece:
        here = robot.pose()
        return motion.spin(here, goal.target_yaw - (here.yaw - start.yaw), robot.base.turning_rate)

    yield from perform(robot, rest, goal.time_allowance, Spin.Result.TIMEOUT)
    return done()


def _ordered(text: str, _world: World) -> Spin.Goal:
    values = numbers(text.split())
    if len(values) != 1:
        raise ValueError(f"expected one number of radians, got {text!r}")
    return Spin.Goal(target_yaw=values[0])


ACTION = Action(
    name="spin",
    goal=Spin.Goal,
    result=Spin.Result,
    feedback=Spin.Feedback,
    process=_process,
    outlives_breakdown=True,
    failure=lambda code, message: Spin.Result(error_code=code, error_msg=message),
    codes=Codes.of_nav2(Spin.Result),
    order=Order("Spin", "RADIANS", _ordered),
    inputs={
        "target_yaw": Input("Angle, counter-clockwise where y points up", "rad", default=1.57),
        "time_allowance": Input("Time allowance, 0 for any", "s", minimum=0.0, advanced=True),
    },
    example={"target_yaw": 1.57},
)
