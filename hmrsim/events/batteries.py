"""Batteries of robots: their levels, and charging."""

from __future__ import annotations

from typing import Annotated, Final

from pydantic import Field

from hmrsim.events._event import Event, EventGroup
from hmrsim.events._fields import Number, Position, RobotName


class BatteryEvent(Event):
    """Something about a robot's battery."""

    robot: RobotName
    charge: Annotated[Number, Field(description="What is in it, in the world's units of energy.")]
    percentage: Annotated[Number, Field(description="The share of its capacity that is left, from 0 to 1.")]


class BatteryLow(BatteryEvent, kind="battery_low", severity="warning", text="has a low battery ({percentage:percent})"):
    """A battery has come down to its low level."""


class BatteryCritical(
    BatteryEvent, kind="battery_critical", severity="warning", text="has a critical battery ({percentage:percent})"
):
    """A battery has come down to its critical level."""


class BatteryEmpty(BatteryEvent, kind="battery_empty", severity="error", text="has an empty battery"):
    """A battery is empty, and its robot stops."""

    at: Position


class BatteryRevived(BatteryEvent, kind="battery_revived", text="has power again ({percentage:percent})"):
    """A battery that was empty has been charged so far that its robot can drive."""


class BatteryFull(BatteryEvent, kind="battery_full", text="has a full battery"):
    """A battery is full."""


class ChargingBegan(BatteryEvent, kind="charging_began", text="starts charging ({percentage:percent})"):
    """A battery is being charged."""


class ChargingEnded(BatteryEvent, kind="charging_ended", text="stops charging ({percentage:percent})"):
    """A battery is no longer being charged."""


EVENTS: Final = EventGroup(
    "batteries",
    (BatteryLow, BatteryCritical, BatteryEmpty, BatteryRevived, BatteryFull, ChargingBegan, ChargingEnded),
)
