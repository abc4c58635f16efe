"""Leave a dock for its staging pose."""

from __future__ import annotations

from collections.abc import Generator
from typing import TYPE_CHECKING, Any

from hmrsim.actions import Action, Codes, Order, Report
from hmrsim.actions._inputs import Input
from hmrsim.errors import GoalAborted
from hmrsim.interfaces.nav2_msgs import UndockRobot

if TYPE_CHECKING:
    from hmrsim.robots.docking import DockBay
    from hmrsim.robots.robot import Robot
    from hmrsim.world.model import World

_RESULT = UndockRobot.Result


def _process(
    robot: Robot, goal: UndockRobot.Goal, _report: Report[UndockRobot.Feedback]
) -> Generator[Any, Any, UndockRobot.Result]:
    dock = _find(robot)
    if goal.dock_type not in ("", dock.spec.type):
        raise GoalAborted(_RESULT.DOCK_NOT_VALID, f"{dock.name!r} is a {dock.spec.type}, not a {goal.dock_type}")
    seconds = goal.max_undocking_time
    late = GoalAborted(_RESULT.TIMEOUT, f"can't leave {dock.name!r} within {seconds:g} s")
    try:
        with robot.within(seconds, late):
            # The robot counts as undocked as soon as it moves.
            yield from robot.drive(robot.plan_to(dock.staging), None)
    except GoalAborted as why:
        if why.code == late.code:
            raise
        raise GoalAborted(_RESULT.FAILED_TO_CONTROL, f"can't leave {dock.name!r}: {why}", why.cause) from None
    if robot.dock is dock:
        dock.release(robot)
    return UndockRobot.Result()


def _find(robot: Robot) -> DockBay:
    """Return the dock at which a robot is docked, or in whose bay it still stands.

    Raises:
        GoalAborted: The robot is not docked.
    """
    dock = robot.dock or next((dock for dock in robot.docks.values() if dock.holds(robot.pose().point)), None)
    if dock is None:
        raise GoalAborted(_RESULT.DOCK_NOT_VALID, f"{robot.name} is not docked")
    return dock


def _ordered(text: str, _world: World) -> UndockRobot.Goal:
    if text:
        raise ValueError(f"nothing comes after Undock, got {text!r}")
    return UndockRobot.Goal()


ACTION = Action(
    name="undock_robot",
    goal=UndockRobot.Goal,
    result=UndockRobot.Result,
    feedback=UndockRobot.Feedback,
    process=_process,
    failure=lambda code, message: UndockRobot.Result(success=False, error_code=code, error_msg=message),
    codes=Codes.of_nav2(_RESULT),
    order=Order("Undock", "", _ordered),
    inputs={"max_undocking_time": Input("Longest time to undock", "s", minimum=0.0, advanced=True)},
    example={},
    example_after="dock_robot",
)
