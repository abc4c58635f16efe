"""The charge of batteries, as a share.

It is known where a battery is read: with its events, and in a simulation that runs with each instant at which anything
happens; in a recording about once a second.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.components.battery import BatterySettings
from hmrsim.events.robots import BATTERIES
from hmrsim.history.occurrence import BatterySeen, SceneSeen, number, records, text
from hmrsim.properties.observing.signal import Signal

if TYPE_CHECKING:
    from hmrsim.history.timeline import Timeline
    from hmrsim.world.model import World


class Batteries:
    """Follows the batteries of a world.

    Attributes:
        shares: The signal of each battery that is asked for, by its robot.
    """

    def __init__(self, world: World, timeline: Timeline) -> None:
        self._world = world
        self.shares: dict[str, Signal] = {}
        for kind in BATTERIES.events:
            timeline.on(kind, lambda _at, event: self._set(event.robot, event.percentage))
        timeline.on(BatterySeen, lambda _at, seen: self._set(seen.robot, seen.percentage))
        timeline.on(SceneSeen, self._see)

    def share(self, robot: str) -> Signal:
        """Return the share that is left in a robot's battery; 1 if it has none."""
        if robot not in self.shares:
            self.shares[robot] = Signal(self._initial(robot))
        return self.shares[robot]

    def begin_anew(self) -> None:
        """Let all batteries have what they have at the start."""
        for robot, signal in self.shares.items():
            signal.set(self._initial(robot))

    def _initial(self, robot: str) -> float:
        spec = self._world.robots.get(robot)
        settings = self._world.robot_type(spec).components.get("battery") if spec else None
        if settings is None:
            return 1.0
        battery = BatterySettings.model_validate(settings)
        return 1.0 if battery.initial_charge is None else battery.initial_charge / battery.capacity

    def _set(self, robot: str, share: float) -> None:
        signal = self.shares.get(robot)
        if signal is not None:
            signal.set(share)

    def _see(self, _at: int, scene: SceneSeen) -> None:
        for robot in records(scene.fields, "robots"):
            battery = robot.get("battery")
            if isinstance(battery, dict):
                self._set(text(robot, "name"), number(battery, "percentage"))
