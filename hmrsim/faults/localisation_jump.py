"""The localization of the robot is off: it publishes another pose than it has."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Annotated

from pydantic import Field

from hmrsim.faults import Case, FaultType, Name, Spell
from hmrsim.geometry import MAX_COORDINATE, Pose

_Number = Annotated[float, Field(strict=True, ge=-MAX_COORDINATE, le=MAX_COORDINATE)]
_Offset = Annotated[_Number, Field(json_schema_extra={"unit": "m"})]


class LocalisationJump(Spell):
    """An error of a robot's published pose.

    Attributes:
        robot: The robot's name.
        dx: Error along x, in the world's unit.
        dy: Error along y, in the world's unit.
        yaw: Error of the yaw, in radians.
    """

    robot: Name
    dx: _Offset = 0.0
    dy: _Offset = 0.0
    yaw: Annotated[_Number, Field(json_schema_extra={"unit": "rad"})] = 0.0


def _begin(case: Case[LocalisationJump]) -> Callable[[], None]:
    robot = case.robot

    def update(jumps: tuple[LocalisationJump, ...]) -> None:
        jumps = (*case.concurrent(), *jumps)
        error = Pose(*(sum(getattr(jump, key) for jump in jumps) for key in ("dx", "dy", "yaw")))
        robot.set_localization_error(error)

    update((case.settings,))
    return partial(update, ())


FAULT = FaultType(
    name="localisation_jump",
    settings=LocalisationJump,
    begin=_begin,
    example={"robot": "wall_e", "dx": 0.5},
    title="Localization jump",
)
