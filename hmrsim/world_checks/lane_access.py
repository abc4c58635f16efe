"""From where on the lanes a point is reached, and what is cut off where a robot stands."""

from __future__ import annotations

import math
from collections import defaultdict
from functools import cached_property
from typing import TYPE_CHECKING

from hmrsim.geometry import SAME_PLACE, distance, foot
from hmrsim.traffic.policies._nearness import rooms_of_waypoints
from hmrsim.world.segments import SegmentGrid

if TYPE_CHECKING:
    from hmrsim.geometry import Obstacles, Point
    from hmrsim.traffic.policies.reserve import ReserveSettings
    from hmrsim.world.model import World

Ends = tuple[str, ...]
"""A place on the lanes: a waypoint, or the two at the ends of a lane."""

_MAX_LOOKED = 2_000_000
"""Maximum number of lanes that all searches look at together, which takes a second or two."""


class LaneAccess:
    """The lanes of a world without errors, which has at least one.

    Args:
        world: The world.
        settings: The settings of its traffic policy, for capacities.
    """

    def __init__(self, world: World, settings: ReserveSettings) -> None:
        self._world = world
        self._settings = settings
        self._points = world.points
        self._rooms = rooms_of_waypoints(world, settings.waypoint_capacity)
        self._names = {self._points[end]: end for lane in world.lanes for end in (lane.from_, lane.to)}
        self._looked = 0

    @cached_property
    def _grid(self) -> SegmentGrid:
        return SegmentGrid([(self._points[lane.from_], self._points[lane.to]) for lane in self._world.lanes])

    @cached_property
    def neighbors(self) -> dict[str, list[str]]:
        """The waypoints that a lane or a lift joins with each waypoint, in either direction."""
        found: defaultdict[str, dict[str, None]] = defaultdict(dict)
        for way in self._world.ways:
            found[way.start][way.end] = found[way.end][way.start] = None
        return {name: [*others] for name, others in found.items()}

    def ends(self, i: int) -> tuple[str, str]:
        """Return the waypoints at the ends of a lane."""
        lane = self._world.lanes[i]
        return lane.from_, lane.to

    def foot(self, point: Point, i: int) -> Point:
        """Return the nearest point of a lane."""
        a, b = self.ends(i)
        return foot(point, self._points[a], self._points[b])

    def ends_nearest(self, point: Point, i: int) -> bool:
        """Return whether the nearest point of a lane is one of its ends."""
        return any(distance(self.foot(point, i), self._points[end]) <= SAME_PLACE for end in self.ends(i))

    def within(self, point: Point, reach: float) -> list[tuple[float, int]]:
        """Return the distances and indices of the lanes within reach of a point, the nearest first."""
        near = ((distance(point, self.foot(point, i)), i) for i in self._grid.within(point, reach))
        return sorted((away, i) for away, i in near if away <= reach)

    def at(self, point: Point) -> Ends:
        """Return the waypoint or the lane at a point; nothing beside the lanes."""
        if point in self._names:
            return (self._names[point],)
        for _, i in self.within(point, SAME_PLACE):
            return self.ends(i)
        return ()

    def to(self, point: Point) -> Ends:
        """Return the waypoint or the lane from which a point is reached: where it is, or the nearest one."""
        if at := self.at(point):
            return at
        reach = 1.0
        while not (near := self.within(point, reach)):
            reach *= 2.0
        nearest = near[0][1]
        return self.at(self.foot(point, nearest)) or self.ends(nearest)

    def room(self, at: Ends) -> float:
        """Return how many robots have room at a waypoint, or on a lane."""
        if len(at) == 1:
            return self._rooms[at[0]]
        lane = next(lane for lane in self._world.lanes if (lane.from_, lane.to) == at)
        return lane.capacity or self._settings.lane_capacity or math.inf

    def seen(self, point: Point, reach: float, obstacles: Obstacles) -> bool:
        """Return whether a straight line within reach leads from a point to a lane, past the obstacles."""
        for _, i in self.within(point, reach):
            a, b = self.ends(i)
            edges = obstacles.edges_of_shadow(point, self._points[a], self._points[b])
            for goal in (self.foot(point, i), *edges):
                if distance(point, goal) <= reach and not obstacles.block(point, goal):
                    return True
        return False

    def behind(self, at: Ends) -> set[str]:
        """Return the waypoints to which no way leads past a robot that stands somewhere on the lanes.

        Of the sides of that place, the largest one is not behind it. Nothing is, once too much has been searched.
        """
        sides: list[set[str]] = []
        for first in self.neighbors[at[0]] if len(at) == 1 else at:
            if not any(first in side for side in sides):
                sides.append(self._side(first, at))
        if self._looked > _MAX_LOOKED:
            return set()
        sides.sort(key=len)
        return set().union(*sides[:-1])

    def _side(self, first: str, at: Ends) -> set[str]:
        """Return the waypoints that are joined with one, but not past a place."""
        side, ahead = {first}, [first]
        while ahead and self._looked <= _MAX_LOOKED:
            name = ahead.pop()
            self._looked += len(self.neighbors[name])
            for other in self.neighbors[name]:
                barred = other in at if len(at) == 1 else {name, other} == {*at}
                if other not in side and not barred:
                    side.add(other)
                    ahead.append(other)
        return side
