"""The wheels of the robot slip: it is slower, also on the lane that it is on."""

from __future__ import annotations

import math
from collections.abc import Callable

from hmrsim.distributions import RandomFactor, mean
from hmrsim.faults import Case, FaultType, Name, Spell


class Slip(Spell):
    """Slip of a robot, which makes it slower.

    Attributes:
        robot: The robot's name.
        factor: Factor on the robot's speed.
    """

    robot: Name
    factor: RandomFactor


def _begin(case: Case[Slip]) -> Callable[[], None]:
    robot = case.robot

    def update(factor: float) -> None:
        robot.scale_speed(factor * math.prod(mean(other.factor) for other in case.concurrent()))

    update(mean(case.settings.factor))
    return lambda: update(1.0)


FAULT = FaultType(
    name="slip",
    settings=Slip,
    begin=_begin,
    example={"robot": "wall_e", "factor": 0.5},
    title="Wheel slip",
    changes="speed",
)
