"""BatteryGuard: a mission that is suspended to charge the battery, and then resumed."""

from __future__ import annotations

from bt_controller.behaviours.charging import BatteryGuard
from bt_controller.nodes import Family

FAMILY = Family.of("battery_guard", BatteryGuard)
