"""The battery has less charge than it reported: the charge drops suddenly to a share of the capacity."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated

from pydantic import Field

from hmrsim.faults import Case, FaultType, Name, Occurrence


class BatteryDrop(Occurrence):
    """A sudden drop of a battery's charge.

    Attributes:
        robot: The robot's name.
        share: The share of the capacity that is left, from 0 to 1; a lower charge does not change.
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
    text="the battery of {robot} falls to {share:.0%}",
)
