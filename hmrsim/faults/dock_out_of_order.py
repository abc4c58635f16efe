"""The dock is out of order: no robot can dock there, and those that are docked are not charged."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, cast

from hmrsim.faults import Case, FaultType, Name, Spell

if TYPE_CHECKING:
    from hmrsim.facilities.docks import DockBays


class DockOutOfOrder(Spell):
    """The outage of a dock.

    Attributes:
        dock: The dock's name.
    """

    dock: Name


def _begin(case: Case[DockOutOfOrder]) -> Callable[[], None]:
    dock = cast("DockBays", case.roster.fixtures[case.settings.dock])
    dock.fail()
    return dock.repair


FAULT = FaultType(
    name="dock_out_of_order",
    settings=DockOutOfOrder,
    begin=_begin,
    example={"dock": "charger"},
    title="Out of order",
)
