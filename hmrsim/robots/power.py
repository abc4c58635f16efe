"""Power: the load of a robot on its battery, and the effect of an empty battery on the robot.

The load is constant between two changes of the robot's activity. So there is one event for each published level, and
none in between. It is an alarm: time does not advance for a battery alone.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from enum import IntEnum
from typing import TYPE_CHECKING, Final, Protocol

from hmrsim.engine.sim_time import nanoseconds
from hmrsim.events.robots import (
    BatteryCritical,
    BatteryEmpty,
    BatteryEvent,
    BatteryFull,
    BatteryLow,
    BatteryRevived,
    ChargingBegan,
    ChargingEnded,
)
from hmrsim.interfaces.builtin_interfaces import Time
from hmrsim.interfaces.sensor_msgs import BatteryState
from hmrsim.interfaces.std_msgs import Header
from hmrsim.protocol.goal import Cause
from hmrsim.protocol.topics import Topic

if TYPE_CHECKING:
    from hmrsim.components.battery import Battery
    from hmrsim.engine.environment import Alarm, Environment
    from hmrsim.engine.subscriptions import EventPublisher
    from hmrsim.geometry import Point, Pose
    from hmrsim.robots.docking import DockBay

EMPTY: Final = Cause.BATTERY_EMPTY.value
"""The cause for which an empty battery disables its robot."""

_REVIVED = 0.01
"""The minimum charge, as a share above empty, with which a robot resumes, however low *critical* is."""

_INSTANT = 1e-9
"""The time in seconds by which an event may come too early."""


class Level(IntEnum):
    """The level of a battery, as published."""

    GOOD = 0
    LOW = 1
    CRITICAL = 2
    EMPTY = 3


_LOWEST_FIRST: Final = (Level.EMPTY, Level.CRITICAL, Level.LOW)


class PoweredRobot(Protocol):
    """The part of a robot that its battery uses."""

    @property
    def name(self) -> str:
        """The name in the world file."""

    @property
    def load(self) -> float:
        """The total weight of the items that it carries, in kg."""

    @property
    def doing(self) -> Sequence[str]:
        """The actions of its active goals."""

    @property
    def dock(self) -> DockBay | None:
        """The dock where it is docked, if any."""

    @property
    def disabled_reasons(self) -> Mapping[str, str]:
        """The reasons for which it is disabled, by cause."""

    @property
    def why_held_up(self) -> str:
        """The obstacle that holds the robot up, such as the queue of a dock; empty if there is none."""

    def pose(self) -> Pose:
        """Return its current pose."""

    def velocity(self) -> tuple[float, float]:
        """Return the current forward speed and turning rate."""

    def disable(self, cause: str, why: str) -> None:
        """Keep it from acting until this and all other causes have ended."""

    def enable(self, cause: str) -> None:
        """End a cause for which it is disabled."""


class Energy:
    """The energy of one robot: charges and drains its battery, and publishes the battery's levels.

    Args:
        robot: The robot, which calls a method of this object whenever its activity changes.

    Attributes:
        level: The last published level; an empty battery stays EMPTY until the robot can resume.
    """

    def __init__(self, env: Environment, robot: PoweredRobot, battery: Battery, publisher: EventPublisher) -> None:
        self.battery = battery
        self._env = env
        self._robot = robot
        self._publisher = publisher
        self._moves = False
        self._alarm: Alarm | None = None
        self._alarm_at = self._due = math.inf
        self._target = 0.0
        self._observers: list[Callable[[], None]] = []
        settings = battery.settings
        # The power at rest and in motion.
        self._powers = settings.drain.of_time(moving=False), settings.drain.of_time(moving=True)
        self._shares = (math.inf, settings.low, settings.critical, settings.stops_below)
        battery.rebase(env.now)
        self.level = self._level(battery.charge(env.now))
        self.switch()

    def look(self, *, moves: bool) -> None:
        """Record whether the robot moves, and how fast; called for each lane."""
        if moves is not self._moves or self.battery.settings.drain.distance:
            self._moves = moves
            self.switch()

    def switch(self) -> None:
        """Update the load, or the charging power, for the robot's current activity."""
        battery, now = self.battery, self._env.now
        charge = battery.settle(now)
        if Level.GOOD < self.level < Level.EMPTY:
            # A level that rises is not published.
            self.level = min(self.level, self._level(charge))
        charged_before = bool(battery.charging)
        power = self._robot.dock.power_for(battery) if self._robot.dock else 0.0
        if power:
            # The dock supplies the robot, even if the battery is full.
            battery.drain, battery.charging = 0.0, power if charge < battery.usable else 0.0
        else:
            battery.drain, battery.charging = 0.0 if self.level is Level.EMPTY else self._demand(), 0.0
        if charged_before is not bool(battery.charging):
            self._publish(ChargingEnded if charged_before else ChargingBegan)
        self._expect(charge)
        for changed in self._observers:
            changed()

    def observe(self, changed: Callable[[], None]) -> None:
        """Call a function whenever the load changes or the charge jumps, until `ignore`."""
        self._observers.append(changed)

    def ignore(self, changed: Callable[[], None]) -> None:
        """Remove a callback of `observe`."""
        self._observers.remove(changed)

    def _demand(self) -> float:
        """Return the power that the robot needs, in units of energy per second."""
        robot, drain = self._robot, self.battery.settings.drain
        power = self._powers[self._moves]
        if drain.distance and self._moves:
            power += drain.distance * abs(robot.velocity()[0])
        if drain.load:
            power += drain.load * robot.load
        if drain.actions:
            power += math.fsum(drain.actions.get(action, 0.0) for action in robot.doing)
        return power

    def act(self) -> None:
        """Record that a goal begins or ends."""
        if self.battery.settings.drain.actions:
            self.switch()

    def carry(self, *, handled: bool) -> None:
        """Record that the carried load has changed, and the energy for that if the robot has *handled* it itself."""
        drain = self.battery.settings.drain
        if handled and drain.handling:
            self.battery.spend(self._env.now, drain.handling)
        if drain.load or drain.handling:
            self.switch()

    def fail_cell(self, cell: int) -> None:
        """Make a cell fail, by its number from 0."""
        self.battery.fail_cell(self._env.now, cell)
        self.switch()

    def mend(self, cell: int) -> None:
        """Replace a cell that has failed."""
        self.battery.mend(self._env.now, cell)
        self.switch()

    def drop_to(self, share: float) -> None:
        """Lower the charge at once to a share of the capacity."""
        self.battery.drop(self._env.now, share * self.battery.usable)
        self.switch()

    def stop(self) -> None:
        """Cancel the alarm, because the robot was removed or time is reset."""
        self.battery.settle(self._env.now)
        if self._alarm is not None:
            self._env.cancel(self._alarm)
            self._alarm = None

    def go_on(self) -> None:
        """Resume at another time after `stop`."""
        self.battery.rebase(self._env.now)
        self._expect(self.battery.charge(self._env.now))

    def _level(self, charge: float) -> Level:
        """Return the level of a charge; that of the current charge may differ from the published one."""
        usable = self.battery.usable
        for level in _LOWEST_FIRST:
            if charge <= usable * self._shares[level]:
                return level
        return Level.GOOD

    @property
    def _revived_at(self) -> float:
        settings = self.battery.settings
        return self.battery.usable * max(settings.stops_below + _REVIVED, settings.critical)

    def _expect(self, charge: float) -> None:
        """Set the alarm for the time at which the charge reaches the next level, or earlier."""
        battery, now = self.battery, self._env.now
        if battery.charging:
            self._target = self._revived_at if self.level is Level.EMPTY else battery.usable
        elif self.level is Level.EMPTY:
            self._due = math.inf
            return
        else:
            self._target = battery.usable * self._shares[self.level + 1]
            if charge <= self._target:
                # Changes at this instant come first.
                self._env.call_soon(self._publish_levels)
                return
        self._due = battery.reaches(self._target)
        if self._alarm is not None and self._due < self._alarm_at:
            self._env.cancel(self._alarm)
            self._alarm = None
        if self._alarm is None and self._due < math.inf:
            # An early alarm, if the load falls meanwhile, is cheaper than a new one at each change.
            self._alarm_at = self._due
            self._alarm = self._env.alarm(max(0.0, self._due - now), self._ring)

    def _ring(self) -> None:
        self._alarm = None
        now = self._env.now
        if self._due > now + _INSTANT:
            if self._due < math.inf:
                self._expect(self.battery.charge(now))
            return
        # The formula reaches the level within rounding errors; set it exactly.
        bound = max if self.battery.charging else min
        self.battery.settle(now, bound(self._target, self.battery.charge(now)))
        if not self.battery.charging:
            self._publish_levels()
        elif self.level is Level.EMPTY:
            self.level = self._level(self.battery.charge(now))
            self._robot.enable(EMPTY)
            self._publish(BatteryRevived)
        else:
            self._publish(BatteryFull)
        self.switch()

    def _publish_levels(self) -> None:
        """Publish each level that was reached; an empty battery disables the robot."""
        for level in Level:
            if self.level < level <= self._level(self.battery.charge(self._env.now)):
                self.level = level
                if level is not Level.EMPTY:
                    self._publish(BatteryLow if level is Level.LOW else BatteryCritical)
        if self.level is Level.EMPTY and EMPTY not in self._robot.disabled_reasons:
            self._publish(BatteryEmpty, self._robot.pose().point)
            self._robot.disable(EMPTY, self.why_empty)
        self.switch()

    @property
    def why_empty(self) -> str:
        """The reason for which an empty battery disables its robot."""
        x, y = self._robot.pose().point
        held_up = self._robot.why_held_up
        return f"battery empty at ({x:g}, {y:g}){f'; held up until then: {held_up}' if held_up else ''}"

    @property
    def tags(self) -> list[str]:
        """The state of the battery as tags of the robot, without EMPTY, which disables the robot."""
        charging = ["charging"] if self.battery.charging else []
        # `level` does not follow a charge that rises.
        level = min(self.level, self._level(self.battery.charge(self._env.now)))
        return charging + ([f"battery_{level.name.lower()}"] if level in (Level.LOW, Level.CRITICAL) else [])

    def _publish(self, event: Callable[..., BatteryEvent], *more: Point) -> None:
        now = self._env.now
        charge, share = self.battery.charge(now), self.battery.share(now)
        self._publisher.publish(lambda: event(self._robot.name, charge, share, *more))
        self._publisher.sampled(Topic.BATTERY_STATE, self._robot.name, self.state)

    def state(self) -> BatteryState:
        """Return the state of the battery as a message."""
        battery, now = self.battery, self._env.now
        settings, flow, volts = battery.settings, battery.flow(now), battery.cell_voltages(now)
        technology = f"POWER_SUPPLY_TECHNOLOGY_{settings.technology.upper()}"
        return BatteryState(
            header=Header(stamp=Time.from_nanoseconds(nanoseconds(now)), frame_id=f"{self._robot.name}/base_link"),
            voltage=math.fsum(volts),
            temperature=settings.temperature,
            current=flow / settings.nominal_voltage + 0.0,
            charge=battery.ampere_hours(battery.charge(now)),
            capacity=battery.ampere_hours(battery.usable),
            design_capacity=battery.ampere_hours(settings.capacity),
            percentage=battery.share(now),
            power_supply_status=self._status(flow),
            power_supply_health=self._health(),
            power_supply_technology=getattr(BatteryState, technology),
            present=True,
            cell_voltage=volts,
            cell_temperature=[settings.temperature] * settings.cells,
            location=self._robot.dock.name if self._robot.dock else "",
            serial_number=self._robot.name,
        )

    def _status(self, flow: float) -> int:
        if flow > 0.0:
            return BatteryState.POWER_SUPPLY_STATUS_CHARGING
        if flow < 0.0:
            return BatteryState.POWER_SUPPLY_STATUS_DISCHARGING
        if self._robot.dock and self._robot.dock.power_for(self.battery):
            return BatteryState.POWER_SUPPLY_STATUS_FULL
        return BatteryState.POWER_SUPPLY_STATUS_NOT_CHARGING

    def _health(self) -> int:
        if not self.battery.failed:
            return BatteryState.POWER_SUPPLY_HEALTH_GOOD
        if self.battery.usable:
            return BatteryState.POWER_SUPPLY_HEALTH_UNSPEC_FAILURE
        return BatteryState.POWER_SUPPLY_HEALTH_DEAD
