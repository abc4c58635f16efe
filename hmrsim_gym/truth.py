"""The ground truth of a run, read from its simulator: positions of robots and items, batteries and docks."""

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
    """Reads the state of a simulator without changing it.

    Attributes:
        demand: The orders of the world.
    """

    def __init__(self, simulator: Simulator, setting: Setting) -> None:
        self._roster, self._env = simulator.roster, simulator.env
        self._setting = setting
        self.demand: Demand = simulator.demand

    def point(self, robot: str) -> Point:
        """Return the position of a robot."""
        return self._roster.robots[robot].pose().point

    def item_point(self, order: Order) -> Point:
        """Return the position of an order's item."""
        return self._roster.items[order.item].position

    def destination(self, order: Order) -> Point:
        """Return the point to which an order's item is delivered."""
        return self._setting.world.point(order.to)

    def carries(self, robot: str, order: Order) -> bool:
        """Return whether a robot carries an order's item."""
        item = self._roster.items.get(order.item)
        return item is not None and item.carrier is not None and item.carrier.name == robot

    def seconds(self, robot: str, start: Point, goal: Point) -> float:
        """Return the seconds that a robot takes at its maximum speed, along the route, or straight if it flies."""
        its = self._roster.robots[robot]
        if its.flies:
            return distance(start, goal) / its.speed
        return self._setting.routes.seconds(start, goal, its.speed)

    def battery(self, robot: str) -> float:
        """Return the charge of a robot's battery as a share; 1 if it has none."""
        energy = self._roster.robots[robot].energy
        return 1.0 if energy is None else energy.battery.share(self._env.now)

    def lasts(self, robot: str) -> float:
        """Return the seconds until a robot has to charge at its present power; infinite if it never has to."""
        energy, now = self._roster.robots[robot].energy, self._env.now
        if energy is None or not self._setting.chargers[robot]:
            return math.inf
        flow, left = energy.battery.flow(now), energy.battery.share(now) - self._setting.charge_below
        # A whole second later, so that rounding can't leave it just above the limit.
        return math.floor(left * energy.battery.usable / -flow) + 1.0 if flow < 0 else math.inf

    def charger(self, robot: str, bound: Mapping[str, str]) -> str:
        """Return the nearest free charger for a robot, or the nearest of all if none is free.

        Args:
            robot: A robot that may charge.
            bound: The chargers to which robots are driving, by the robot's name.
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
