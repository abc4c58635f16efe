"""Batteries of robots: their levels, and charging."""

from __future__ import annotations

from typing import Annotated, Final

from pydantic import Field

from hmrsim.events._event import Event, EventGroup
from hmrsim.events._fields import Number, Position, RobotName
from hmrsim.events._parts import Part


class BatteryEvent(Event, changes=Part.BATTERY):
    """A change of a robot's battery."""

    robot: RobotName
    charge: Annotated[Number, Field(description="Its charge, in the world's units of energy.")]
    percentage: Annotated[Number, Field(description="The share of its capacity that is left, from 0 to 1.")]


class BatteryLow(
    BatteryEvent,
    kind="battery_low",
    severity="warning",
    text="has a low battery ({percentage:percent})",
    sets={"level": "low"},
):
    """A battery has fallen to its low level."""


class BatteryCritical(
    BatteryEvent,
    kind="battery_critical",
    severity="warning",
    text="has a critical battery ({percentage:percent})",
    sets={"level": "critical"},
):
    """A battery has fallen to its critical level."""


class BatteryEmpty(
    BatteryEvent,
    kind="battery_empty",
    severity="error",
    text="has an empty battery",
    sets={"level": "empty", "disables": "battery_empty"},
):
    """A battery is empty, and its robot stops."""

    at: Position


class BatteryRevived(
    BatteryEvent,
    kind="battery_revived",
    text="has power again ({percentage:percent})",
    sets={"level": "", "enables": "battery_empty"},
):
    """A battery that was empty has enough charge for its robot to drive."""


class BatteryFull(BatteryEvent, kind="battery_full", text="has a full battery", sets={"level": ""}):
    """A battery is full."""


class ChargingBegan(
    BatteryEvent, kind="charging_began", text="starts charging ({percentage:percent})", sets={"charging": True}
):
    """A battery is being charged."""


class ChargingEnded(
    BatteryEvent, kind="charging_ended", text="stops charging ({percentage:percent})", sets={"charging": False}
):
    """A battery is no longer being charged."""


EVENTS: Final = EventGroup(
    "batteries",
    (BatteryLow, BatteryCritical, BatteryEmpty, BatteryRevived, BatteryFull, ChargingBegan, ChargingEnded),
)
