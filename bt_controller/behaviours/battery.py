"""Behaviors on the robot's battery: one that writes its state on the blackboard, and one that waits for a charge."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

from py_trees.common import Access, Status

from bt_controller.behaviours import subscribers
from hmrsim.interfaces.sensor_msgs import BatteryState

if TYPE_CHECKING:
    from hmrsim_zenoh.client.connection import Condition

_HYSTERESIS: Final = 5.0
"""The warning ends this many per cent above the threshold."""


class ToBlackboard(subscribers.ToBlackboard):
    """Writes ``battery``, the latest BatteryState, and ``battery_low_warning`` on the blackboard.

    The class is named as in py_trees_ros. The warning begins below the threshold and ends five per cent above it, so
    that it does not flicker.

    Args:
        threshold: Per cent of the capacity.
        robot: The robot; None for the robot of the tree.
    """

    def __init__(
        self, name: str = "Battery to blackboard", *, threshold: float = 30.0, robot: str | None = None
    ) -> None:
        initial = {"battery_low_warning": False}
        super().__init__(name, "battery_state", "battery", initialise_variables=initial, robot=robot)
        self._threshold = threshold
        self.blackboard.register_key("battery_low_warning", Access.READ)

    def update(self) -> Status:
        """Write the latest message and the warning on the blackboard."""
        status = super().update()
        if status is Status.SUCCESS:
            battery: BatteryState = self.message()
            percent = battery.percentage * 100.0
            if percent > self._threshold + _HYSTERESIS:
                self.blackboard.set("battery_low_warning", value=False)
            elif percent < self._threshold:
                self.blackboard.set("battery_low_warning", value=True)
            low = self.blackboard.get("battery_low_warning")
            self.feedback_message = f"battery level is {'low' if low else 'ok'}: {percent:.0f} %"
        return status


class WaitUntilCharged(subscribers.Handler):
    """Waits until the battery has reached a charge; fails if it does not charge, or stops charging.

    Args:
        percentage: The charge as a share of the capacity, from 0 to 1, as in a BatteryState.
        name: The behavior's name; by default one with the charge, such as ``Charge to 90%``.
        robot: The robot; None for the robot of the tree.
    """

    def __init__(self, percentage: float = 0.9, *, name: str | None = None, robot: str | None = None) -> None:
        super().__init__(name or f"Charge to {percentage:.0%}", "battery_state", robot=robot)
        self._percentage = percentage

    def awaited(self) -> Sequence[Condition]:
        """Return the conditions that end the wait: the battery has reached the charge, or no longer charges."""
        level, charging = "/percentage", "/power_supply_status"
        return self._conditions(
            (level, ">=", self._percentage), (charging, "!=", BatteryState.POWER_SUPPLY_STATUS_CHARGING)
        )

    def update(self) -> Status:
        """Return SUCCESS if the battery has reached the charge or is full, else RUNNING while it charges."""
        battery: BatteryState = self.message()
        self.feedback_message = f"battery: {battery.percentage:.0%}"
        if battery.percentage >= self._percentage or is_full(battery):
            return Status.SUCCESS
        return Status.RUNNING if is_charging(battery) else Status.FAILURE


def is_charging(battery: BatteryState) -> bool:
    """Return whether a battery is charging."""
    return battery.power_supply_status == battery.POWER_SUPPLY_STATUS_CHARGING


def is_full(battery: BatteryState) -> bool:
    """Return whether a battery is fully charged."""
    return battery.power_supply_status == battery.POWER_SUPPLY_STATUS_FULL
