"""The wheels of the robot slip: it is slower, also on the lane that it is on."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Annotated

from pydantic import Field

from hmrsim.faults import Case, FaultType, Name, Spell


class Slip(Spell):
    """When which robot slips.

    Attributes:
        robot: Its name.
        factor: What its speed is multiplied with.
    """

    robot: Name
    factor: Annotated[float, Field(strict=True, gt=0, le=1)]


def _begin(case: Case[Slip]) -> Callable[[], None]:
    robot = case.robot

    def update(factor: float) -> None:
        robot.scale_speed(factor * math.prod(other.factor for other in case.concurrent()))

    update(case.settings.factor)
    return lambda: update(1.0)


FAULT = FaultType(
    name="slip",
    settings=Slip,
    begin=_begin,
    example={"robot": "wall_e", "factor": 0.5},
    title="Wheel slip",
    changes="speed",
)
