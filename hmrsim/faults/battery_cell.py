"""A cell of the battery fails: its charge is lost, and less can be charged."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated

from pydantic import Field

from hmrsim.faults import Case, FaultType, Name, Spell


class BatteryCell(Spell):
    """The failure of a battery cell.

    Attributes:
        robot: The robot's name.
        cell: The cell's number, from 0.
    """

    robot: Name
    cell: Annotated[int, Field(strict=True, ge=0)] = 0


def _begin(case: Case[BatteryCell]) -> Callable[[], None]:
    energy, cell = case.robot.energy, case.settings.cell
    if energy is None:
        raise AssertionError
    energy.fail_cell(cell)

    def end() -> None:
        if all(other.cell != cell for other in case.concurrent()):
            energy.mend(cell)

    return end


FAULT = FaultType(
    name="battery_cell",
    settings=BatteryCell,
    begin=_begin,
    component="battery",
    example={"robot": "wall_e"},
    title="Battery cell fails",
)
