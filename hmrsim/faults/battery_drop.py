"""The battery has less left than it said: its charge falls to a share of what it holds, at once."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated

from pydantic import Field

from hmrsim.faults import Case, FaultType, Name, Occurrence


class BatteryDrop(Occurrence):
    """When the charge of which battery falls.

    Attributes:
        robot: The robot's name.
        share: What is left of its capacity, from 0 to 1; one that has less already keeps that.
    """

    robot: Name
    share: Annotated[float, Field(strict=True, ge=0, le=1)]


def _begin(case: Case[BatteryDrop]) -> Callable[[], None]:
    energy = case.robot.energy
    if energy is None:
        raise AssertionError
    energy.drop_to(case.settings.share)
    return lambda: None


FAULT = FaultType(
    name="battery_drop",
    settings=BatteryDrop,
    begin=_begin,
    component="battery",
    example={"robot": "wall_e", "share": 0.5},
    title="Battery drops",
)
