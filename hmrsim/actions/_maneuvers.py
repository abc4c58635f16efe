"""Common parts of maneuvers without a route: motions in a given time, and results with the elapsed time."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator
from typing import TYPE_CHECKING, Any, TypeVar

from hmrsim.actions._inputs import numbers
from hmrsim.errors import BaseDisabled, GoalAborted
from hmrsim.geometry import SAME_PLACE, distance
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.nav2_msgs import BackUp, DriveOnHeading, Spin, Wait
from hmrsim.navigation.motion import drive_of, straight
from hmrsim.protocol.goal import Cause

if TYPE_CHECKING:
    from hmrsim.actions import Report
    from hmrsim.geometry import Point
    from hmrsim.navigation.motion import Piece
    from hmrsim.robots.robot import Robot
    from hmrsim.world.model import World

R = TypeVar("R", Wait.Result, Spin.Result, BackUp.Result, DriveOnHeading.Result)


def keep_time(robot: Robot, report: Report[Any], result: type[R]) -> Callable[[], R]:
    """Put the elapsed time into the result, however the goal ends; return the factory of a successful result."""
    began = robot.now

    def make(code: int, message: str) -> R:
        return result(total_elapsed_time=Duration.from_seconds(robot.now - began), error_code=code, error_msg=message)

    report.on_failure(make)
    return lambda: make(0, "")


def perform(
    robot: Robot, rest: Callable[[], Piece | None], allowance: Duration, timeout: int
) -> Generator[Any, Any, None]:
    """Run a motion of a robot within the time allowance; zero is no limit.

    A robot that has broken down makes the rest of it when it works again, as one whose behavior server keeps on
    commanding a velocity. *rest* returns what is left of the motion from where the robot stands; None for nothing.

    Raises:
        GoalAborted: The time is over, and the robot has stopped; with the code *timeout*.
    """
    allowed = allowance.to_seconds()
    seconds = left = allowed if allowed > 0.0 else math.inf
    until = robot.now + seconds
    over = f"the time allowance of {seconds:g} s is over"
    while (piece := rest()) is not None:
        late = left < piece.duration
        try:
            yield from robot.perform(drive_of(piece.first(left) if late else piece))
        except BaseDisabled as why:
            yield from robot.wait_until_enabled(until)
            left = until - robot.now
            if left <= 0.0:
                raise GoalAborted(timeout, f"{over}; {why}") from None
            continue
        if late:
            raise GoalAborted(timeout, f"{over}; it takes {piece.duration:g} s")
        return


def drive_straight(
    robot: Robot, goal: BackUp.Goal | DriveOnHeading.Goal, how_far: float, codes: Any
) -> Generator[Any, Any, None]:
    """Drive a robot straight ahead, or back if *how_far* is negative, at the goal's speed or its own maximum.

    *how_far* is in the world's unit; *codes* is the action's result type, which has its codes.

    Raises:
        GoalAborted: Something blocks the way, and the robot stands before it; or the time is over.
    """
    flaw = _flaw(goal)
    if flaw:
        raise GoalAborted(codes.INVALID_INPUT, flaw)
    start = robot.pose()
    target = start.x + how_far * math.cos(start.yaw), start.y + how_far * math.sin(start.yaw)
    blocked = ""

    def rest() -> Piece | None:
        nonlocal blocked
        here = robot.pose()
        end, blocked = robot.graph.reach(robot.pose().point, target, flies=robot.flies)
        if distance(here.point, end) <= SAME_PLACE:
            return None
        speed = min(abs(goal.speed), robot.speed)
        return straight(here, end, speed=speed, acceleration=robot.base.acceleration)

    yield from perform(robot, rest, goal.time_allowance, codes.TIMEOUT)
    if blocked:
        raise GoalAborted(codes.COLLISION_AHEAD, f"blocked: {blocked}", Cause.BLOCKED)


def travelled_from(robot: Robot) -> Callable[[], dict[str, float]]:
    """Return the source of the feedback of a robot that drives straight from its current pose."""
    start: Point = robot.pose().point
    return lambda: {"distance_traveled": robot.distance_to(start)}


def _flaw(goal: BackUp.Goal | DriveOnHeading.Goal) -> str:
    if goal.target.y or goal.target.z:
        return f"target ({goal.target.x:g}, {goal.target.y:g}, {goal.target.z:g}) is not straight ahead; give x alone"
    if goal.target.x and not goal.speed:
        return "at speed 0 it would take for ever; give another"
    return ""


def distance_ordered(text: str, world: World) -> dict[str, Any]:
    """Return the fields of the goal to drive a distance at a speed, by default that of robots without one.

    Raises:
        ValueError: The words aren't one or two positive numbers.
    """
    how_far, *speed = numbers(text.split()) or [0.0]
    if len(speed) > 1 or min([how_far, *speed]) <= 0:
        raise ValueError(f"expected a distance, and perhaps a speed, both positive, got {text!r}")
    # Controllers read actions, too, but no orders: they need not load what worlds are made of.
    from hmrsim.world.model import Base  # noqa: PLC0415

    return {"target": {"x": how_far}, "speed": speed[0] if speed else world.speed(Base())}
