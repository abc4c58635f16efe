"""A battery: its charge is a formula of time between two changes of the load.

A unit of energy is a watt second, so that volts, amperes and ampere hours follow from it. A battery charges at a
constant power up to a share of its capacity; from there the power decreases with the charge, as with cells at a
constant voltage, to a twentieth when the battery is full.
"""

from __future__ import annotations

import math
from typing import Annotated, Final, Literal, Self

from pydantic import Field, model_validator

from hmrsim.components import Component, Settings

_Energy = Annotated[float, Field(strict=True, ge=0, le=1e9)]
_Share = Annotated[float, Field(strict=True, ge=0, le=1)]

_LAST_POWER: Final = 0.05
"""Share of the charging power that is left when a battery is full."""


class Drain(Settings):
    """The consumption of a battery, in units of energy; one unit per second is one watt.

    Attributes:
        default: Consumption per second, for *still* and *moving* if they are omitted; None for 1.
        still: Consumption per second while the robot stands.
        moving: Consumption per second while the robot moves.
        distance: Consumption per unit of length that the robot drives, in addition to *moving*.
        load: Consumption per second for each kg that the robot carries.
        handling: Consumption for each item that the robot picks up or puts down.
        actions: Consumption per second while a goal of an action executes, by the action's name.
    """

    default: _Energy | None = None
    still: _Energy | None = None
    moving: _Energy | None = None
    distance: _Energy = 0.0
    load: _Energy = 0.0
    handling: _Energy = 0.0
    actions: dict[str, _Energy] = Field(default_factory=dict)

    def of_time(self, *, moving: bool) -> float:
        """Return the consumption per second of a robot that stands or moves."""
        drain = self.moving if moving else self.still
        if drain is not None:
            return drain
        return 1.0 if self.default is None else self.default


class BatterySettings(Settings):
    """The capacity, consumption and cells of a battery.

    Attributes:
        capacity: Capacity of the battery, in units of energy.
        initial_charge: Charge at the start, in units of energy; None for a full battery.
        drain: The consumers of the battery.
        low: Share of the capacity at which ``battery_low`` is published.
        critical: Share of the capacity at which ``battery_critical`` is published, and to which an empty battery has to
            be charged before the robot can drive again.
        stops_below: Share of the capacity at which the battery counts as empty, as with a battery management system
            that switches the battery off.
        taper_from: Share of the capacity up to which the battery is charged at full power.
        nominal_voltage: Voltage of all cells in series at half charge, in volts.
        cells: The number of cells in series.
        technology: The technology of the cells, as in sensor_msgs/BatteryState.
        temperature: The constant temperature, in degrees Celsius.
    """

    capacity: Annotated[
        float, Field(strict=True, gt=0, le=1e12, description="Capacity of the battery, in units of energy.")
    ] = 3600.0
    initial_charge: Annotated[float, Field(strict=True, ge=0)] | None = None
    drain: Drain = Drain()
    low: _Share = 0.2
    critical: _Share = 0.05
    stops_below: Annotated[float, Field(strict=True, ge=0, le=0.95)] = 0.0
    taper_from: _Share = 0.8
    nominal_voltage: Annotated[float, Field(strict=True, gt=0, le=1e6)] = 25.2
    cells: Annotated[int, Field(strict=True, ge=1, le=1000)] = 7
    technology: Literal["unknown", "nimh", "lion", "lipo", "life", "nicd", "limn", "ternary", "vrla"] = "lion"
    temperature: Annotated[float, Field(strict=True, ge=-273.15, le=1000)] = 20.0

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if self.initial_charge is not None and self.initial_charge > self.capacity:
            raise ValueError(f"initial_charge {self.initial_charge:g} is more than the capacity {self.capacity:g}")
        if self.critical > self.low:
            raise ValueError(f"critical {self.critical:g} is more than low {self.low:g}")
        if self.stops_below > self.critical:
            raise ValueError(f"stops_below {self.stops_below:g} is more than critical {self.critical:g}")
        return self


class Battery:
    """One robot's battery; the caller that changes its load passes the time of the change.

    Attributes:
        drain: Units of energy a second that go out.
        charging: Those that go in at full power; 0 while it is not being charged.
        drained: Energy drawn since the start.
        charged: Energy charged since the start.
        usable: Units of energy that it holds when full, by the cells that work.
        failed: The failed cells, by number from 0.
    """

    def __init__(self, settings: BatterySettings) -> None:
        self.settings = settings
        self.drain = self.charging = 0.0
        self.drained = self.charged = 0.0
        self.failed: frozenset[int] = frozenset()
        self.usable = settings.capacity
        self._charge = settings.capacity if settings.initial_charge is None else settings.initial_charge
        self._since = 0.0

    def charge(self, now: float) -> float:
        """Return the units of energy in it."""
        if now <= self._since:
            return self._charge
        elapsed = now - self._since
        if not self.charging:
            return max(0.0, self._charge - self.drain * elapsed)
        full, taper = self.usable, self._taper_from
        constant = max(0.0, taper - self._charge) / self.charging
        if elapsed <= constant:
            return min(full, self._charge + self.charging * elapsed)
        limit, slowness = self._taper
        tapered = limit - (limit - max(taper, self._charge)) * math.exp((constant - elapsed) / slowness)
        return min(full, tapered)

    def used(self, now: float) -> float:
        """Return the units of energy drawn since the start."""
        return self.drained + max(0.0, self._charge - self.charge(now))

    def share(self, now: float) -> float:
        """Return the charge as a share of the capacity, from 0 to 1."""
        return self.charge(now) / self.usable if self.usable else 0.0

    def flow(self, now: float) -> float:
        """Return the units of energy a second that go in now; negative when they go out."""
        charge = self.charge(now)
        if not self.charging:
            return -self.drain if charge > 0.0 else 0.0
        if charge >= self.usable:
            return 0.0
        if charge < self._taper_from:
            return self.charging
        limit, slowness = self._taper
        return (limit - charge) / slowness

    def reaches(self, level: float) -> float:
        """Return the time at which the charge reaches a level if nothing changes; infinite if it never does."""
        if not self.charging:
            return self._since + max(0.0, self._charge - level) / self.drain if self.drain else math.inf
        taper = self._taper_from
        constant = max(0.0, min(taper, level) - self._charge) / self.charging
        if level <= max(taper, self._charge):
            return self._since + constant
        limit, slowness = self._taper
        tapering = slowness * math.log((limit - max(taper, self._charge)) / (limit - level))
        return self._since + (constant + tapering)

    @property
    def _taper_from(self) -> float:
        return self.settings.taper_from * self.usable

    @property
    def _taper(self) -> tuple[float, float]:
        """The charge that charging approaches, and the time constant of the exponential approach."""
        begins = self._taper_from
        limit = (self.usable - _LAST_POWER * begins) / (1.0 - _LAST_POWER)
        # Without a taper, which is never asked for then, nothing is left of it.
        return limit, max(limit - begins, 1e-300) / self.charging

    def settle(self, now: float, charge: float | None = None) -> float:
        """Update the charge by the formula, or to *charge* where the exact value is known, and return it."""
        charge = self.charge(now) if charge is None else charge
        change = charge - self._charge
        if change > 0.0:
            self.charged += change
        else:
            self.drained -= change
        self._charge, self._since = charge, now
        return charge

    def spend(self, now: float, energy: float) -> None:
        """Remove units of energy at once, or all energy if there is less."""
        self.settle(now)
        self.settle(now, max(0.0, self._charge - energy))

    def drop(self, now: float, charge: float) -> None:
        """Reduce the energy to a maximum at once."""
        self.settle(now)
        self.settle(now, min(self._charge, charge))

    def rebase(self, to: float) -> None:
        """Set the current time, without charging or discharging."""
        self._since = to

    def fail_cell(self, now: float, cell: int) -> None:
        """Make a cell fail, by its number from 0, and lose its charge; the other cells keep theirs."""
        self._resize(now, self.failed | {range(self.settings.cells)[cell]})

    def mend(self, now: float, cell: int) -> None:
        """Replace a failed cell by one that is as full as the others, or full if there are no others."""
        self._resize(now, self.failed - {cell})

    def _resize(self, now: float, failed: frozenset[int]) -> None:
        share = self.share(now) if self.usable else 1.0
        self.settle(now)
        self.failed = failed
        self.usable = self.settings.capacity * (1.0 - len(failed) / self.settings.cells)
        self.settle(now, share * self.usable)

    def ampere_hours(self, energy: float) -> float:
        """Return energy as the charge that it is at the nominal voltage."""
        return energy / self.settings.nominal_voltage / 3600.0

    def energy(self, ampere_hours: float) -> float:
        """Return a charge at the nominal voltage as energy."""
        return ampere_hours * self.settings.nominal_voltage * 3600.0

    def cell_voltages(self, now: float) -> list[float]:
        """Return the voltage of each cell: linear in its charge, from 0.9 to 1.1 of the nominal voltage.

        A failed cell has no voltage.
        """
        settings = self.settings
        volts = settings.nominal_voltage / settings.cells * voltage_at(self.share(now))
        return [0.0 if cell in self.failed else volts for cell in range(settings.cells)]


def voltage_at(share: float) -> float:
    """Return the voltage of a battery with a charge from 0 to 1, as a share of the nominal voltage."""
    return 0.9 + 0.2 * share


COMPONENT = Component(name="battery", settings=BatterySettings, create=Battery)
