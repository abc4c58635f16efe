"""BatteryGuard: a mission that is interrupted to charge, and goes on where it was."""

from __future__ import annotations

from bt_controller.behaviours.charging import BatteryGuard
from bt_controller.nodes import Family

FAMILY = Family("battery_guard", {"BatteryGuard": BatteryGuard})
