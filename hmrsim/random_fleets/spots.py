"""Random points off the waypoints where robots stand, with doors and racks around them."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

from hmrsim.geometry import between, distance, foot, gap

if TYPE_CHECKING:
    import random

    from hmrsim.geometry import Point
    from hmrsim.random_fleets.layout import Lane, Layout

ROOM = 1.0
"""Minimum meters between two such points, except for places deliberately close to a waypoint."""

_HALF_DOOR = 1.0
_RACK = 1.4
"""Meters from a lane to the rack beside it."""

_LEAST_RACK = 1.0
_TRIES = 30


class Spot(NamedTuple):
    """A point where a robot can stand off the waypoints.

    Attributes:
        at: The point.
        near: The waypoint or lane that it belongs to.
        on_lane: Whether it is in the middle of a lane.
    """

    at: Point
    near: str
    on_lane: bool = False


@dataclass
class Site:
    """Lanes with the things beside them.

    Attributes:
        doors: The ends of each door.
        racks: The outlines of solid obstacles.
        spots: The points off the waypoints that are taken.
    """

    chance: random.Random
    layout: Layout
    doors: list[tuple[Point, Point]] = field(default_factory=list)
    racks: list[list[Point]] = field(default_factory=list)
    spots: list[Spot] = field(default_factory=list)

    def add_doors(self, count: int) -> list[Lane]:
        """Add doors in the middle of lanes, and return these lanes."""
        lanes = self.chance.sample(self.layout.lanes, min(count, len(self.layout.lanes)))
        lanes = [lane for lane in lanes if distance(*self.layout.segment(lane)) > 3.0]  # noqa: PLR2004 - not of a bay
        for lane in lanes:
            a, b = self.layout.segment(lane)
            length = distance(a, b)
            across = -(b[1] - a[1]) / length * _HALF_DOOR, (b[0] - a[0]) / length * _HALF_DOOR
            x, y = between(a, b, 0.5)
            self.doors.append((_rounded(x - across[0], y - across[1]), _rounded(x + across[0], y + across[1])))
        return lanes

    def add_racks(self, share: float) -> None:
        """Fill some of the rectangles between lanes with racks, if they are free."""
        for left, low, right, high in self.layout.faces:
            if self.chance.random() >= share:
                continue
            left_, low_, right_, high_ = left + _RACK, low + _RACK, right - _RACK, high - _RACK
            if right_ - left_ < _LEAST_RACK or high_ - low_ < _LEAST_RACK:
                continue
            outline = [(left_, low_), (right_, low_), (right_, high_), (left_, high_)]
            if not self._is_in_the_way(outline):
                self.racks.append(outline)

    def _is_in_the_way(self, outline: list[Point]) -> bool:
        sides = [*zip(outline, [*outline[1:], outline[0]], strict=True)]
        lines = [*map(self.layout.segment, self.layout.lanes), *self.doors]
        lines += [(spot.at, self._foot(spot)) for spot in self.spots]
        return any(gap(*line, *side) < ROOM / 2 or _is_inside(line[0], outline) for line in lines for side in sides)

    def _foot(self, spot: Spot) -> Point:
        """Return the nearest point of a lane."""
        feet = [foot(spot.at, *self.layout.segment(lane)) for lane in self.layout.lanes]
        return min(feet, key=lambda at: distance(spot.at, at))

    def beside_waypoint(self) -> Spot | None:
        """Add a point so close to a waypoint that two robots touch there."""
        for _ in range(_TRIES):
            name = self.chance.choice([*self.layout.waypoints])
            x, y = self.layout.waypoints[name]
            dx, dy = self.chance.choice(((0.5, 0.0), (0.0, 0.5), (-0.5, 0.0), (0.0, -0.5)))
            at = _rounded(x + dx, y + dy)
            lanes = [lane for lane in self.layout.lanes if name in (lane.start, lane.end)]
            if any(distance(at, foot(at, *self.layout.segment(lane))) < 0.49 for lane in lanes):  # noqa: PLR2004
                # It would be on a lane of the waypoint.
                continue
            if self._is_free(at, except_for=name):
                return self._taken(Spot(at, name))
        return None

    def beside_lane(self) -> Spot | None:
        """Add a point 0.5 to 3 m beside a lane."""
        for _ in range(_TRIES):
            lane = self.chance.choice(self.layout.lanes)
            a, b = self.layout.segment(lane)
            length, away = distance(a, b), self.chance.choice((0.5, 0.8, 1.0, 1.5, 2.0, 3.0))
            side = self.chance.choice((-1, 1))
            x, y = between(a, b, self.chance.choice((0.25, 0.3, 0.5, 0.5, 0.7, 0.75)))
            at = _rounded(x - side * away * (b[1] - a[1]) / length, y + side * away * (b[0] - a[0]) / length)
            others = [other for other in self.layout.lanes if other is not lane]
            nearest = min((distance(at, foot(at, *self.layout.segment(other))) for other in others), default=math.inf)
            if nearest > max(ROOM, away + 0.1) and self._is_free(at):
                return self._taken(Spot(at, f"{lane.start}-{lane.end}"))
        return None

    def on_lane(self) -> Spot | None:
        """Add a point in the middle of a lane."""
        for _ in range(_TRIES):
            lane = self.chance.choice(self.layout.lanes)
            at = _rounded(*between(*self.layout.segment(lane), self.chance.choice((0.3, 0.4, 0.5, 0.6))))
            on_line = distance(at, foot(at, *self.layout.segment(lane))) < 1e-9  # noqa: PLR2004 - rounded all the same
            if on_line and self._is_free(at):
                return self._taken(Spot(at, f"{lane.start}-{lane.end}", on_lane=True))
        return None

    def _taken(self, spot: Spot) -> Spot:
        self.spots.append(spot)
        return spot

    def _is_free(self, at: Point, except_for: str = "") -> bool:
        points = [point for name, point in self.layout.waypoints.items() if name != except_for]
        points += [spot.at for spot in self.spots]
        if any(distance(at, point) < ROOM for point in points):
            return False
        return all(distance(at, foot(at, *door)) >= ROOM / 2 for door in self.doors)


def _is_inside(point: Point, outline: list[Point]) -> bool:
    (left, low), (right, high) = outline[0], outline[2]
    return left <= point[0] <= right and low <= point[1] <= high


def _rounded(x: float, y: float) -> Point:
    return round(x, 2), round(y, 2)
