"""A battery: its settings are read and kept; nothing drains it yet."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from pydantic import Field

from hmrsim.components import Component, Settings


class BatterySettings(Settings):
    """How much a battery holds."""

    capacity: Annotated[float, Field(strict=True, gt=0, description="Units of energy when full.")] = 3600.0


@dataclass
class Battery:
    """One robot's battery."""

    settings: BatterySettings


COMPONENT = Component(name="battery", settings=BatterySettings, create=Battery)
