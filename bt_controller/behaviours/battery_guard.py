"""A mission that is suspended while a low battery is charged, and then resumed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bt_controller.behaviours.charging import BatteryGuard as BatteryGuardNode
from bt_controller.core.port_values import connect

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour


class BatteryGuard(BatteryGuardNode):
    """Runs a mission, and suspends it to charge when the battery is low.

    ::

        BatteryGuard("Guard", mission=errand, charge=Dock("charger_1"), below=0.2, until=0.9)

    Args:
        name: The behavior's name.
        mission: The mission. It and its timers stand still while the battery is charged: its active goals are
            canceled and sent again afterwards, and its finished steps stay finished. First the robot drives back to
            where it was interrupted, unless the mission resumes with a drive.
        charge: The subtree that charges the battery. If it ends while the battery is charging, as docking does, the
            guard waits for the charge; if it waits and undocks itself, the mission resumes at once.
        below: The share of the capacity below which to charge, from 0 to 1.
        until: The share from which the mission resumes.
        robot: The robot with the battery; None for the one that the tree is run for.
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
