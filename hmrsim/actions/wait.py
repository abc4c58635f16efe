"""Stand still for a duration."""

from __future__ import annotations

from collections.abc import Generator
from typing import TYPE_CHECKING, Any

from hmrsim.actions import Action, Codes, Order, Report
from hmrsim.actions._inputs import Input, numbers
from hmrsim.actions._maneuvers import keep_time
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.nav2_msgs import Wait

if TYPE_CHECKING:
    from hmrsim.robots.robot import Robot
    from hmrsim.world.model import World


_MAX_SECONDS = 2**31 - 1
"""Whole seconds that a ROS duration can state."""


def _process(robot: Robot, goal: Wait.Goal, report: Report[Wait.Feedback]) -> Generator[Any, Any, Wait.Result]:
    seconds = max(0.0, goal.time.to_seconds())
    until = robot.now + seconds
    done = keep_time(robot, report, Wait.Result)
    report.sample(lambda: Wait.Feedback(time_left=Duration.from_seconds(max(0.0, until - robot.now))))
    yield from robot.hold(seconds)
    return done()


def _ordered(text: str, _world: World) -> Wait.Goal:
    seconds = numbers(text.split())
    if len(seconds) != 1 or not 0 <= seconds[0] <= _MAX_SECONDS:
        raise ValueError(f"expected one number of seconds, from 0 to {_MAX_SECONDS}, got {text!r}")
    return Wait.Goal(time=Duration.from_seconds(seconds[0]))


ACTION = Action(
    name="wait",
    goal=Wait.Goal,
    result=Wait.Result,
    feedback=Wait.Feedback,
    process=_process,
    outlives_breakdown=True,
    failure=lambda code, message: Wait.Result(error_code=code, error_msg=message),
    codes=Codes.of_nav2(Wait.Result),
    order=Order("Wait", "SECONDS", _ordered),
    inputs={"time": Input("Duration", "s", default=5.0, minimum=0.0)},
    example={"time": {"sec": 2}},
)
