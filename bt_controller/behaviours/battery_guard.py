"""A mission that is interrupted when the battery is low, and goes on where it was when that is charged."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bt_controller.behaviours.charging import BatteryGuard as BatteryGuardNode
from bt_controller.core.port_values import connect

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour


class BatteryGuard(BatteryGuardNode):
    """Runs a mission; in between, when the battery is low, what charges it.

    ::

        BatteryGuard("Guard", mission=errand, charge=Dock("charger_1"), below=0.2, until=0.9)

    Args:
        name: The behaviour's name.
        mission: What to do. It stands still while the battery is charged, and so do its timers: its goals are
            canceled, its finished steps stay finished, and what was canceled is sent again. Before that the robot
            drives back to where it was interrupted, unless it goes on with a drive to somewhere.
        charge: What charges the battery. If it ends while the battery is charging, as with a dock, that is waited
            for; if it waits itself and undocks, too, the mission goes on at once.
        below: The share of the capacity below which to charge, from 0 to 1.
        until: The share from which the mission goes on.
        robot: Whose battery; None for the robot that the tree is run for.
    """

    def __init__(
        self,
        name: str,
        mission: Behaviour,
        charge: Behaviour,
        *,
        below: float = 0.2,
        until: float = 0.9,
        robot: str | None = None,
    ) -> None:
        super().__init__(name, children=[mission, charge], robot=robot)
        connect(self, below=below, until=until)
