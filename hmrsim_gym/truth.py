"""What is true in a run, read from its simulator: where robots and items are, how full batteries are, who is docked."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from typing import TYPE_CHECKING

from hmrsim.geometry import distance

if TYPE_CHECKING:
    from hmrsim.geometry import Point
    from hmrsim.simulation.demand import Demand
    from hmrsim.simulation.orders import Order
    from hmrsim.simulation.simulator import Simulator
    from hmrsim_gym.setting import Setting


class Truth:
    """Reads a simulator, and changes nothing.

    Attributes:
        demand: The orders of the world.
    """

    def __init__(self, simulator: Simulator, setting: Setting) -> None:
        self._roster, self._env = simulator.roster, simulator.env
        self._setting = setting
        self.demand: Demand = simulator.demand

    def point(self, robot: str) -> Point:
        """Return where a robot is."""
        return self._roster.robots[robot].pose().point

    def item_point(self, order: Order) -> Point:
        """Return where an order's item is."""
        return self._roster.items[order.item].position

    def destination(self, order: Order) -> Point:
        """Return where an order's item has to be brought."""
        return self._setting.world.point(order.to)

    def carries(self, robot: str, order: Order) -> bool:
        """Return whether a robot carries an order's item."""
        item = self._roster.items.get(order.item)
        return item is not None and item.carrier is not None and item.carrier.name == robot

    def seconds(self, robot: str, start: Point, goal: Point) -> float:
        """Return how long a robot's way takes at its greatest speed, by route, or straight if it flies."""
        its = self._roster.robots[robot]
        if its.flies:
            return distance(start, goal) / its.speed
        return self._setting.routes.seconds(start, goal, its.speed)

    def battery(self, robot: str) -> float:
        """Return how full a robot's battery is; 1 if it has none."""
        energy = self._roster.robots[robot].energy
        return 1.0 if energy is None else energy.battery.share(self._env.now)

    def may_charge(self, robot: str) -> bool:
        """Return whether a robot has a battery, and there is a charger for it."""
        return bool(self._setting.chargers[robot]) and self._roster.robots[robot].energy is not None

    def lasts(self, robot: str) -> float:
        """Return in how many seconds a robot has to charge if it goes on as now; infinite for never."""
        energy, now = self._roster.robots[robot].energy, self._env.now
        if energy is None or not self._setting.chargers[robot]:
            return math.inf
        flow, left = energy.battery.flow(now), energy.battery.share(now) - self._setting.charge_below
        # A whole second later than needed, so that it is low then for certain.
        return math.floor(left * energy.battery.usable / -flow) + 1.0 if flow < 0 else math.inf

    def charger(self, robot: str, bound: Mapping[str, str]) -> str:
        """Return the nearest charger for a robot, of those that are free if there are any.

        Args:
            robot: One that may charge.
            bound: The chargers to which others are bound, by the robot's name.
        """
        chargers, here = self._setting.chargers[robot], self.point(robot)
        docked = {name: its.dock.name for name, its in self._roster.robots.items() if its.dock is not None}
        others = Counter(dock for name, dock in {**docked, **bound}.items() if name != robot)
        return min(
            chargers,
            key=lambda name: (
                others[name] >= chargers[name].capacity,
                self.seconds(robot, here, chargers[name].at),
                name,
            ),
        )
