"""Robots that stand in the way of others: at places too near to lanes or too far from them, and at bad starts.

All of this follows from the world file, before a robot has moved. It matters under policies with reservations, where a
standing robot keeps others out. There is no warning if the policy makes the robot move.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

from hmrsim.diagnostics import Finding, listed, warning
from hmrsim.geometry import METER, SAME_PLACE, Obstacles, distance
from hmrsim.traffic.nearness import rooms_of_waypoints, touch
from hmrsim.traffic.policies import settings_of
from hmrsim.traffic.policies.priority import PrioritySettings
from hmrsim.traffic.policies.reserve import ReserveSettings
from hmrsim.world.model import DEFAULT_POLICY
from hmrsim.world_checks.lanes import LaneIndex

if TYPE_CHECKING:
    from hmrsim.diagnostics import Path
    from hmrsim.geometry import Point
    from hmrsim.world.model import World

_Ends = tuple[str, ...]
"""A part of the lanes: a waypoint, or the two ends of a lane."""

_MAX_LOOKED = 2_000_000
"""Maximum number of lanes visited by all searches together, which takes a second or two."""

_FAR = 5.0
"""Meters from the lanes up to which a place is beside them."""

_MEETING = 2
"""The minimum number of robots for one to be in the way of another."""


def check_obstructions(world: World) -> Iterator[Finding]:
    """Yield a warning for each place and start at which a robot will be in the way of others.

    The world must have no errors.
    """
    settings = settings_of(world)
    if isinstance(settings, ReserveSettings) and world.lanes:
        obstructions = _Obstructions(world, settings)
        yield from obstructions.check_distances()
        yield from obstructions.check_starts()


class _Spot(NamedTuple):
    """A point beside the lanes where robots stand.

    Attributes:
        path: Where the file has it.
        clearance: How far away the centers of others have to stay.
    """

    path: Path
    point: Point
    clearance: float


class _Obstructions:
    """A world under a policy with reservations."""

    def __init__(self, world: World, settings: ReserveSettings) -> None:
        self._world = world
        self._far = _FAR * METER[world.units]
        self._yields = isinstance(settings, PrioritySettings)
        self._lanes = _LaneAccess(world, settings)
        bases = {name: world.robot_type(robot).base for name, robot in world.robots.items()}
        self._radii = {name: base.radius or 0.0 for name, base in bases.items() if not base.flies}

    def check_distances(self) -> Iterator[Finding]:
        """Yield the spots where a robot blocks a waypoint or lane for others, or that are far from the lanes."""
        units = self._world.units
        for spot in self._spots():
            x, y = spot.point
            if blocked := self._blocked(spot):
                at, away = blocked
                kind, name = ("waypoint", repr(at[0])) if len(at) == 1 else ("lane", f"{at[0]!r}-{at[1]!r}")
                text = (
                    f"({x:g}, {y:g}) is {away:.3g} {units} from {kind} {name}, and two robots need {spot.clearance:.3g}"
                    f" {units}: one that stands here keeps others out of the {kind}; move it away to"
                    f" {spot.clearance:.3g} {units} or more"
                )
                yield warning(spot.path, text, [x, y])
            elif self._is_far(spot.point):
                text = (
                    f"({x:g}, {y:g}) is more than {self._far:g} {units} from each lane that leads there: robots don't"
                    " keep apart on that way; add a lane that ends nearer to it"
                )
                yield warning(spot.path, text, [x, y])

    def _spots(self) -> Iterator[_Spot]:
        """Yield the places, docks and starts beside the lanes, each point once; none if no two robots can touch."""
        world, robots = self._world, self._radii
        if len(robots) < _MEETING or not any(robots.values()):
            return
        clearance = self._clearance(*robots)
        spots = [_Spot(("places", name, "at"), place.at, clearance) for name, place in world.places.items()]
        for name in world.docks:
            served = [robot for robot in robots if self._may_dock(robot, name)]
            spots.append(_Spot(("docks", name, "at"), world.dock_point(name), self._clearance(*served)))
        starts = {name: world.point(world.robots[name].at) for name in robots}
        spots += [_Spot(("robots", name, "at"), at, self._clearance(name)) for name, at in starts.items()]
        seen: set[Point] = set()
        for spot in spots:
            if spot.point not in seen and not self._lanes.at(spot.point):
                yield spot
            seen.add(spot.point)

    def _clearance(self, *robots: str) -> float:
        """Return the greatest sum of radii of one of these robots and any other; there must be at least two robots."""
        *_, second, first = sorted(self._radii, key=self._radii.__getitem__)
        others = {name: self._radii[second if name == first else first] for name in robots}
        return max((self._radii[name] + others[name] for name in robots), default=0.0)

    def _may_dock(self, robot: str, dock: str) -> bool:
        reserved_for = self._world.docks[dock].reserved_for
        return reserved_for is None or robot in reserved_for or self._world.robots[robot].type in reserved_for

    def _blocked(self, spot: _Spot) -> tuple[_Ends, float] | None:
        """Return the waypoint, else the lane, that a robot at a spot blocks, and its distance."""
        lanes = self._lanes.within(spot.point, spot.clearance)
        names = {end for _, i in lanes for end in self._lanes.ends(i)}
        waypoints = sorted((distance(spot.point, self._world.points[name]), name) for name in names)
        near: list[tuple[float, _Ends]] = [(away, (name,)) for away, name in waypoints]
        near += [(away, self._lanes.ends(i)) for away, i in lanes if not self._lanes.ends_nearest(spot.point, i)]
        for away, at in near:
            if touch(away, spot.clearance) and self._lanes.room(at) < math.inf and not self._serves(at, spot.point):
                return at, away
        return None

    def _serves(self, at: _Ends, point: Point) -> bool:
        """Return whether a part of the lanes is a dead end that leads to this one point only."""
        for end in at:
            others = self._lanes.neighbors[end]
            users = [self._users.get(key, set()) for key in ((end,), (end, *others), (*others, end))]
            if len(others) == 1 and set().union(*users) <= {point}:
                return True
        return False

    @cached_property
    def _users(self) -> dict[_Ends, set[Point]]:
        """The places, docks, starts and waypoints of orders, by the waypoint or lane from which each is reached."""
        world = self._world
        named = [*world.places, *world.docks, *self._orders, *(robot.at for robot in world.robots.values())]
        found: defaultdict[_Ends, set[Point]] = defaultdict(set)
        for point in dict.fromkeys(map(world.point, named)):
            found[self._lanes.to(point)].add(point)
        return found

    @cached_property
    def _orders(self) -> dict[str, Point]:
        """The places where orders begin or end, by name."""
        names = dict.fromkeys(name for demand in self._world.demand for name in (*demand.at, *demand.to))
        return {name: self._world.point(name) for name in names}

    def _is_far(self, point: Point) -> bool:
        """Return whether no lane is near; places inside obstacles have another warning."""
        return not (self._lanes.seen(point, self._far, self._obstacles) or self._obstacles.occupy(point))

    @cached_property
    def _obstacles(self) -> Obstacles:
        return self._world.obstacles(doors=True)

    def check_starts(self) -> Iterator[Finding]:
        """Yield the robots that start in the way of orders and don't make room.

        Under priority these are docked robots only.
        """
        for robot in self._radii if self._orders and len(self._radii) >= _MEETING else ():
            start = self._world.point(self._world.robots[robot].at)
            dock = self._dock_at(robot, start)
            if self._yields and dock is None:
                continue
            blocked = self._blocked_orders(robot, start)
            if not blocked:
                continue
            if dock is None:
                why = f"under {self._world.policy!r} a robot without a goal does not make room"
                remedy = f"start it elsewhere, or use the policy {DEFAULT_POLICY!r}"
            else:
                why, remedy = "a docked robot does not make room", f"start it elsewhere, or move the dock {dock!r}"
            text = (
                f"({start[0]:g}, {start[1]:g}) is in the way to {listed(blocked)}, where orders begin or end: {why};"
                f" {remedy}"
            )
            yield warning(("robots", robot, "at"), text, [*start])

    def _dock_at(self, robot: str, start: Point) -> str | None:
        """Return the dock where a robot starts, or None."""
        for name in self._world.docks:
            if distance(self._world.dock_point(name), start) <= SAME_PLACE and self._may_dock(robot, name):
                return name
        return None

    def _blocked_orders(self, robot: str, start: Point) -> list[str]:
        """Return the places of orders that other robots can't reach while this one stands at its start."""
        at = self._lanes.at(start)
        fills = bool(at) and self._lanes.room(at) <= 1
        behind = self._lanes.behind(at) if fills else set()
        if fills and len(at) == 1:
            behind |= {*at}

        def is_blocked(place: Point) -> bool:
            away = distance(start, place)
            if away <= SAME_PLACE:
                return fills or not at
            to = {*self._lanes.to(place)}
            return touch(away, self._clearance(robot)) or (fills and (to <= behind or to == {*at}))

        return [name for name, place in self._orders.items() if is_blocked(place)]


class _LaneAccess(LaneIndex):
    """The lanes of a world without errors and with at least one lane.

    Args:
        world: The world.
        settings: The settings of its traffic policy, for capacities.
    """

    def __init__(self, world: World, settings: ReserveSettings) -> None:
        super().__init__(world, world.lanes)
        self._world = world
        self._settings = settings
        self._rooms = rooms_of_waypoints(world, settings.waypoint_capacity)
        self._names = {self._points[end]: end for lane in world.lanes for end in (lane.from_, lane.to)}
        self._looked = 0

    @cached_property
    def neighbors(self) -> dict[str, list[str]]:
        """The waypoints that a lane or lift joins with each waypoint, in either direction."""
        found: defaultdict[str, dict[str, None]] = defaultdict(dict)
        for way in self._world.ways:
            found[way.start][way.end] = found[way.end][way.start] = None
        return {name: [*others] for name, others in found.items()}

    def ends(self, i: int) -> tuple[str, str]:
        """Return the waypoints at the ends of a lane."""
        lane = self._world.lanes[i]
        return lane.from_, lane.to

    def ends_nearest(self, point: Point, i: int) -> bool:
        """Return whether the nearest point of a lane is one of its ends."""
        return any(distance(self.foot(point, i), self._points[end]) <= SAME_PLACE for end in self.ends(i))

    def at(self, point: Point) -> _Ends:
        """Return the waypoint or lane at a point; empty beside the lanes."""
        if point in self._names:
            return (self._names[point],)
        for _, i in self.within(point, SAME_PLACE):
            return self.ends(i)
        return ()

    def to(self, point: Point) -> _Ends:
        """Return the waypoint or lane from which a point is reached: that at the point, or the nearest one."""
        if at := self.at(point):
            return at
        reach = 1.0
        while not (near := self.within(point, reach)):
            reach *= 2.0
        nearest = near[0][1]
        return self.at(self.foot(point, nearest)) or self.ends(nearest)

    def room(self, at: _Ends) -> float:
        """Return the capacity of a waypoint or lane."""
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

    def behind(self, at: _Ends) -> set[str]:
        """Return the waypoints that others can't reach past a robot that stands on this part of the lanes.

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

    def _side(self, first: str, at: _Ends) -> set[str]:
        """Return the waypoints connected with one without passing a part of the lanes."""
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
