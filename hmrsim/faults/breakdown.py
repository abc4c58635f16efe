"""The robot breaks down: it stops where it is, and blocks other robots, until it is repaired."""

from __future__ import annotations

from collections.abc import Callable

from hmrsim.faults import Case, FaultType, Name, Spell


class Breakdown(Spell):
    """The breakdown of a robot.

    Attributes:
        robot: The robot's name.
    """

    robot: Name


def _begin(case: Case[Breakdown]) -> Callable[[], None]:
    robot = case.robot
    x, y = robot.pose().point
    robot.disable(FAULT.name, f"{robot.name} has broken down at ({x:g}, {y:g})")

    def end() -> None:
        if not case.concurrent():
            robot.enable(FAULT.name)

    return end


FAULT = FaultType(name="breakdown", settings=Breakdown, begin=_begin, example={"robot": "wall_e"}, changes="ailments")
