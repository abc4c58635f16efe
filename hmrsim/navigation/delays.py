"""Random delays of robots on lanes and in lifts."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import permutations
from typing import TYPE_CHECKING

from hmrsim.distributions import Distribution
from hmrsim.world.model import PlainLanes

if TYPE_CHECKING:
    from hmrsim.distributions import RandomValue
    from hmrsim.engine.chance import Chance
    from hmrsim.navigation.graph import Lane
    from hmrsim.navigation.route import Leg
    from hmrsim.world.model import Lift, World


class Delays:
    """The lanes and lifts of a world that delay robots randomly; most worlds have none.

    Each trip of a robot has its own values, which don't change when the robot stops and drives on.

    Attributes:
        any: Whether any lane or lift delays robots.
    """

    def __init__(self, world: World, chance: Chance) -> None:
        self._chance = chance
        self._factors: dict[Lane, tuple[RandomValue, float]] = {}
        self._rides: dict[Lane, tuple[str, Lift, int, int]] = {}
        for lane in () if isinstance(world.lanes, PlainLanes) else world.lanes:
            if lane.speed_factor != 1.0:
                factor = lane.speed_factor, lane.speed_limit or math.inf
                self._factors[lane.from_, lane.to] = self._factors[lane.to, lane.from_] = factor
        for name, lift in world.lifts.items():
            if isinstance(lift.travel_time, Distribution) or isinstance(lift.door_time, Distribution):
                for i, j in permutations(range(len(lift.stops)), 2):
                    self._rides[lift.stops[i], lift.stops[j]] = name, lift, i, j
        self.any = bool(self._factors or self._rides)

    def of(self, leg: Leg, robot: str, speed: float, trip: int) -> Leg:
        """Return a leg with the delays of a trip.

        Args:
            leg: A leg of its route.
            robot: The robot's name.
            speed: The robot's maximum speed, in the world's unit per second.
            trip: The number of the robot's trip.
        """
        if leg.lane in self._rides:
            lift, spec, i, j = self._rides[leg.lane]
            travel = self._chance.drawn(spec.travel_time, lift, f"travel_time/{robot}", trip)
            doors = self._chance.drawn(spec.door_time, lift, f"door_time/{robot}", trip)
            return replace(leg, ride=abs(i - j) * travel + 2 * doors)
        if leg.lane in self._factors:
            (start, end), (factor, limit) = leg.lane, self._factors[leg.lane]
            drawn = self._chance.drawn(factor, robot, f"speed_factor/{start}/{end}", trip)
            return replace(leg, speed_limit=min(speed, limit) * drawn)
        return leg
