"""Routes of straight legs in travel order, and the random delays of robots on them."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from itertools import permutations
from typing import TYPE_CHECKING

from hmrsim.distributions import Distribution
from hmrsim.geometry import Point, Pose, heading
from hmrsim.world.model import PlainLanes

if TYPE_CHECKING:
    from hmrsim.distributions import RandomValue
    from hmrsim.engine.chance import Chance
    from hmrsim.world.model import Lift, World


@dataclass(frozen=True, slots=True)
class Leg:
    """A straight piece of a route.

    Attributes:
        length: In the world's unit.
        lane: The waypoints of the lane that it runs on, in its direction; None off the lanes.
        speed_limit: Most that may be driven there; infinite without a limit.
        slots: The slots that a robot occupies on the leg and then at its end, as `hmrsim.traffic.policies` counts:
            the lane, if it is one, and the waypoint at its end, if there is one.
        ride: Seconds that a lift carries the robot, which is at its start until they are over; 0 on a driven leg.
        leaves_for: The point off the lanes to which its robot drives next, and which it needs to begin this leg; None
            if it stays on the lanes.
        joins: The part of a lane that its robot drives next, from the middle of the lane, where it is not to stop; None
            if it ends anywhere else.
        shares_end: Whether several robots may stand at its end, off the lanes, by other rules than those of traffic.
        leads_onto: The lane that it runs on or joins; None if it stays off the lanes.
        first: The pose of a robot that begins to drive it.
        last: The pose of one that has driven it.
    """

    start: Point
    end: Point
    length: float
    lane: tuple[str, str] | None = None
    speed_limit: float = math.inf
    slots: tuple[int, ...] = field(default=(), compare=False)
    ride: float = 0.0
    leaves_for: Point | None = field(default=None, compare=False)
    joins: Leg | None = field(default=None, compare=False, repr=False)
    shares_end: bool = field(default=False, compare=False)
    leads_onto: tuple[str, str] | None = field(init=False, compare=False, repr=False)
    first: Pose = field(init=False, compare=False, repr=False)
    last: Pose = field(init=False, compare=False, repr=False)

    def __post_init__(self) -> None:
        """Turn a robot into the leg's direction: every drive needs it, and most legs are driven often."""
        object.__setattr__(self, "leads_onto", self.lane if self.joins is None else self.joins.lane)
        yaw = heading(self.start, self.end)
        object.__setattr__(self, "first", Pose(*self.start, yaw))
        object.__setattr__(self, "last", Pose(*self.end, yaw))

    def seconds(self, speed: float) -> float:
        """Return the travel time of a robot with this maximum speed, in seconds."""
        return self.ride or self.length / min(speed, self.speed_limit)


@dataclass(frozen=True, slots=True)
class Route:
    """The way from one point to another: legs in order, none when they are the same place.

    Attributes:
        legs: In order.
        goal: The destination, if the robot may be rerouted to it; None if it has to drive these legs.
    """

    legs: tuple[Leg, ...]
    goal: Point | None = None

    @property
    def length(self) -> float:
        """The length of all legs, in the world's unit."""
        return math.fsum(leg.length for leg in self.legs)


class Delays:
    """The lanes and lifts of a world that delay robots randomly; most worlds have none.

    Each trip of a robot has its own values, which don't change when the robot stops and drives on.

    Attributes:
        any: Whether any lane or lift delays robots.
    """

    def __init__(self, world: World, chance: Chance) -> None:
        self._chance = chance
        self._factors: dict[tuple[str, str], tuple[RandomValue, float]] = {}
        self._rides: dict[tuple[str, str], tuple[str, Lift, int, int]] = {}
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
