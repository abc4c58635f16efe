"""A route: straight legs, in travel order."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from hmrsim.geometry import Point, Pose, heading


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
