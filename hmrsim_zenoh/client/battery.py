"""The charge of a robot's battery, and waiting for it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from hmrsim.interfaces.sensor_msgs import BatteryState
from hmrsim_zenoh.client.connection import Condition
from hmrsim_zenoh.errors import NotCharging, Unreachable
from hmrsim_zenoh.wire.envelopes import plain, read_often

if TYPE_CHECKING:
    from hmrsim_zenoh.client.client import Client

_TOPIC: Final = "battery_state"
BATTERY_PERIOD: Final = 1.0
"""Simulated seconds between two readings of a battery where time does not stop for conditions."""
_ROUNDING: Final = 1e-6
"""How far a battery that has reached a charge may seem to be from it."""


def battery_of(client: Client, robot: str) -> BatteryState:
    """Return the state of a robot's battery.

    Raises:
        SimulatorNotFound, SimulatorGone, RequestTimeout: As `Client.get`.
        RequestError, Unreachable: There is no such robot, or it has no battery.
    """
    try:
        answer = client.get(client.keys.topic(robot, _TOPIC))
    except Unreachable:
        why = "it has no battery, or there is no such robot"
        raise Unreachable(f"{robot!r} publishes no {_TOPIC}: {why}") from None
    state: BatteryState = read_often(plain(BatteryState), answer)
    return state


def charged_or_not_charging(robot: str, percentage: float) -> list[Condition]:
    """Return what ends the wait for a share of a battery's capacity.

    Raises:
        ValueError: The share is not from 0 to 1.
    """
    if not 0.0 <= percentage <= 1.0:
        raise ValueError(f"{percentage} is not a share of a capacity; expected a number from 0 to 1")
    key, charging = f"{robot}/{_TOPIC}", BatteryState.POWER_SUPPLY_STATUS_CHARGING
    return [
        Condition(key, [("/percentage", ">=", percentage)]),
        Condition(key, [("/power_supply_status", "!=", charging)]),
    ]


def is_charged(robot: str, state: BatteryState, percentage: float) -> bool:
    """Return whether a battery has a share of its capacity; False while it is charged.

    Raises:
        NotCharging: It has less, and is not charged.
    """
    if state.percentage >= percentage - _ROUNDING:
        return True
    if state.power_supply_status != state.POWER_SUPPLY_STATUS_CHARGING:
        raise NotCharging(
            f"{robot!r} does not charge: its battery is at {state.percentage:.1%}, "
            f"and would never be at {percentage:.1%}; dock it at a charger"
        )
    return False
