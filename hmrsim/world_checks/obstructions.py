"""Robots that stand in the way of others: at places too near to lanes or too far from them, and at bad starts.

All of this follows from the world file, before a robot has moved. It matters under policies with reservations, where a
robot that stands keeps others out, and there is no warning where the policy makes the robot move.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

from hmrsim.diagnostics import Finding, listed, warning
from hmrsim.geometry import SAME_PLACE, Obstacles, distance
from hmrsim.traffic.policies import settings_of
from hmrsim.traffic.policies._nearness import touch
from hmrsim.traffic.policies.priority import PrioritySettings
from hmrsim.traffic.policies.reserve import ReserveSettings
from hmrsim.world.model import DEFAULT_POLICY
from hmrsim.world_checks.lane_access import LaneAccess

if TYPE_CHECKING:
    from hmrsim.diagnostics import Path
    from hmrsim.geometry import Point
    from hmrsim.world.model import World
    from hmrsim.world_checks.lane_access import Ends

_FAR = {"m": 5.0, "px": 400.0}
"""The distance from the lanes, by unit, up to which a place is beside them; 1 m corresponds to 80 px."""

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
        self._yields = isinstance(settings, PrioritySettings)
        self._lanes = LaneAccess(world, settings)
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
                    f"({x:g}, {y:g}) is more than {_FAR[units]:g} {units} from each lane that leads there: robots don't"
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

    def _blocked(self, spot: _Spot) -> tuple[Ends, float] | None:
        """Return the waypoint, else the lane, that a robot at a spot blocks, and its distance."""
        lanes = self._lanes.within(spot.point, spot.clearance)
        names = {end for _, i in lanes for end in self._lanes.ends(i)}
        waypoints = sorted((distance(spot.point, self._world.points[name]), name) for name in names)
        near: list[tuple[float, Ends]] = [(away, (name,)) for away, name in waypoints]
        near += [(away, self._lanes.ends(i)) for away, i in lanes if not self._lanes.ends_nearest(spot.point, i)]
        for away, at in near:
            if touch(away, spot.clearance) and self._lanes.room(at) < math.inf and not self._serves(at, spot.point):
                return at, away
        return None

    def _serves(self, at: Ends, point: Point) -> bool:
        """Return whether a part of the lanes is a dead end that leads to this one point only."""
        for end in at:
            others = self._lanes.neighbors[end]
            users = [self._users.get(key, set()) for key in ((end,), (end, *others), (*others, end))]
            if len(others) == 1 and set().union(*users) <= {point}:
                return True
        return False

    @cached_property
    def _users(self) -> dict[Ends, set[Point]]:
        """The places, docks, starts and waypoints of orders, by the waypoint or lane from which each is reached."""
        world = self._world
        named = [*world.places, *world.docks, *self._orders, *(robot.at for robot in world.robots.values())]
        found: defaultdict[Ends, set[Point]] = defaultdict(set)
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
        reach = _FAR[self._world.units]
        return not (self._lanes.seen(point, reach, self._obstacles) or self._obstacles.occupy(point))

    @cached_property
    def _obstacles(self) -> Obstacles:
        walls = self._world.walls
        outlines = [wall for wall in walls if isinstance(wall, tuple)]
        doors = [door.at for door in self._world.doors.values()]
        return Obstacles([*outlines, *doors], [wall.solid for wall in walls if not isinstance(wall, tuple)])

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
