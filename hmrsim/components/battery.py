"""A battery: its settings are read and kept; nothing drains it yet."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from hmrsim.components import Component, Settings

_Energy = Annotated[float, Field(strict=True, ge=0, le=1e9)]


class BatterySettings(Settings):
    """How much a battery holds, and what empties it.

    Attributes:
        capacity: Units of energy when full.
        initial_charge: Units of energy at the start; None for a full battery.
        drain: Units of energy a second, ``still`` and ``moving``; where one is left out ``default``, or else 1.
    """

    capacity: Annotated[float, Field(strict=True, gt=0, description="Units of energy when full.")] = 3600.0
    initial_charge: _Energy | None = None
    drain: dict[Literal["default", "still", "moving"], _Energy] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if self.initial_charge is not None and self.initial_charge > self.capacity:
            raise ValueError(f"initial_charge {self.initial_charge:g} is more than the capacity {self.capacity:g}")
        return self


@dataclass
class Battery:
    """One robot's battery."""

    settings: BatterySettings


COMPONENT = Component(name="battery", settings=BatterySettings, create=Battery)
