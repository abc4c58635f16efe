"""The checks of docks, doors and lifts."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Mapping
from itertools import combinations, pairwise
from typing import TYPE_CHECKING, Final

from hmrsim.diagnostics import Finding, Path, instead, meant, warning
from hmrsim.geometry import SAME_PLACE, distance, foot
from hmrsim.world.model import BUILT_IN_TYPES
from hmrsim.world.network import connected
from hmrsim.world.segments import SegmentGrid
from hmrsim.world_checks.lanes import LaneIndex, known_lanes, lane_ends, off_the_map
from hmrsim.world_checks.robots import known_start

if TYPE_CHECKING:
    from hmrsim.documents.valid_parts import Lost
    from hmrsim.geometry import Point
    from hmrsim.world.model import Dock, Lift, RobotSpec, World

_DOOR_TYPES: Final = ("door", "sliding", "hinged", "double_sliding", "double_hinged", "telescope", "double_telescope")
"""The usual types of doors: the default, and those of Open-RMF."""

_MISSPELLED: Final = 0.85
"""The similarity from which another type is a misspelled one: *swing* is not *sliding*."""


def check_docks(world: World, lost: Lost) -> Iterator[Finding]:
    """Yield the errors of the docks of a world."""
    for name, dock in world.docks.items():
        path: Path = ("docks", name, "at")
        yield from _check_users(world, ("docks", name, "reserved_for"), dock.reserved_for, lost)
        try:
            point = world.dock_point(name)
        except KeyError:
            if not lost.has(str(dock.at), "waypoints", "places"):
                points = [*world.waypoints, *world.places]
                yield Finding(path, f"no waypoint or place {dock.at!r}{instead(str(dock.at), points)}", dock.at)
            continue
        yield from off_the_map(world, path, point)
        if dock.staging is not None:
            yield from off_the_map(world, ("docks", name, "staging"), dock.staging)


def check_ways_to_docks(world: World, lost: Lost) -> Iterator[Finding]:
    """Yield a warning for each dock that no robot which may dock there can reach."""
    if lost or not world.docks:
        return
    ways = Ways(world)
    for name, dock in world.docks.items():
        path: Path = ("docks", name, "at")
        try:
            x, y = point = world.dock_point(name)
        except KeyError:
            continue
        if any(off_the_map(world, path, point)):
            continue
        if ways.is_walled(point):
            yield warning(path, f"({x:g}, {y:g}) is inside an obstacle, so that no robot gets to {name!r}", [x, y])
        elif message := ways.missing(name, point, _users(world, dock)):
            yield warning(path, message, [x, y])


def _users(world: World, dock: Dock) -> dict[str, RobotSpec]:
    """Return the robots that may dock at a dock, by name."""
    if dock.reserved_for is None:
        return world.robots
    return {
        name: robot
        for name, robot in world.robots.items()
        if name in dock.reserved_for or robot.type in dock.reserved_for
    }


def _check_users(world: World, path: Path, users: Collection[str] | None, lost: Lost) -> Iterator[Finding]:
    """Yield an error for each name that is neither a robot nor a type of robots."""
    known = dict.fromkeys((*world.robots, *world.robot_types, *BUILT_IN_TYPES)) if users else {}
    for i, user in enumerate(users or ()):
        if user not in known and not lost.has(user, "robots", "robot_types"):
            yield Finding((*path, i), f"no robot or robot type {user!r}{instead(user, known)}", user)


class Ways:
    """Points joined by lanes in any direction, or by a straight line without obstacles.

    Args:
        world: The world; its names must be valid, or the invalid parts left out.
    """

    def __init__(self, world: World) -> None:
        self._world = world
        self._obstacles = world.obstacles()
        self._walls = SegmentGrid(world.sides)
        self._lanes = LaneIndex(world, known_lanes(world))
        stops = [lift.stops for lift in world.lifts.values() if {*lift.stops} <= world.points.keys()]
        driven = ((lane.from_, lane.to) for lane in self._lanes.lanes)
        self._part = connected([*driven, *(pair for each in stops for pair in pairwise(each))])
        self._count = len({*self._part.values()})
        self._parts_near: dict[Point, frozenset[str]] = {}

    def is_walled(self, point: Point) -> bool:
        """Return whether a point is inside an obstacle, and on no lane."""
        return self._obstacles.occupy(point) and not self._lanes.lanes_at(point)

    def missing(self, name: str, point: Point, robots: Mapping[str, RobotSpec]) -> str:
        """Return the text of a warning if none of the robots can reach a place; empty if one can, or for no robots."""
        if not robots or any(self._reaches(robot, point) for robot in robots.values()):
            return ""
        who = next(iter(robots)) if len(robots) == 1 else f"any of {len(robots)} robots"
        return f"no way leads to {name!r} at ({point[0]:g}, {point[1]:g}) for {who}; join it with their lanes"

    def _reaches(self, robot: RobotSpec, point: Point) -> bool:
        base, start = known_start(self._world, robot)
        if base is None or start is None or base.flies or distance(start, point) <= SAME_PLACE:
            return True
        if not self._lanes.lanes:
            return not self._obstacles.block(start, point)
        return not self._near(start).isdisjoint(self._near(point))

    def _near(self, point: Point) -> frozenset[str]:
        if point not in self._parts_near:
            self._parts_near[point] = self._find_near(point)
        return self._parts_near[point]

    def _find_near(self, point: Point) -> frozenset[str]:
        """Return the parts that have a lane at a point, or whose nearest point is visible from it."""
        on_lane = [self._part[self._lanes.lanes[i].from_] for i in self._lanes.lanes_at(point)]
        if on_lane or self._obstacles.surround(point):
            return frozenset(on_lane)
        found: dict[str, None] = {}
        for i in self._lanes.grid.outwards(point):
            part = self._part[self._lanes.lanes[i].from_]
            if part not in found and self._walls.first_crossing(point, self._lanes.foot(point, i)) is None:
                found[part] = None
                if len(found) == self._count:
                    break
        return frozenset(found)


def check_fixtures(world: World, lost: Lost) -> Iterator[Finding]:
    """Yield the errors of the doors and lifts of a world."""
    yield from _check_unique_names(world)
    for name, door in world.doors.items():
        path: Path = ("doors", name)
        if distance(*door.at) <= SAME_PLACE:
            yield Finding((*path, "at"), "has no length: name both its jambs", [*map(list, door.at)])
        else:
            yield from _check_users(world, (*path, "opens_for"), door.opens_for, lost)
        # Any description is valid.
        if door.type not in _DOOR_TYPES and (similar := meant(door.type, _DOOR_TYPES, similarity=_MISSPELLED)):
            yield warning((*path, "type"), f"unusual type {door.type!r}; did you mean {similar!r}?", door.type)
    yield from _check_standing(world)
    driven: dict[frozenset[str], str] = {
        frozenset((lane.from_, lane.to)): f"lanes.{i}" for i, lane in enumerate(world.lanes if world.lifts else ())
    }
    for name, lift in world.lifts.items():
        yield from _check_stops(world, name, lift, lost)
        for pair in map(frozenset, combinations(lift.stops, 2)):
            other = driven.setdefault(pair, f"lifts.{name}")
            if other != f"lifts.{name}":
                ends = " and ".join(repr(stop) for stop in sorted(pair))
                yield Finding(("lifts", name, "stops"), f"{ends} are joined by {other} already; keep one of the two")


def check_lanes_through_doors(world: World, lost: Lost) -> Iterator[Finding]:
    """Yield a warning for each door that no lane leads through."""
    if lost or not world.doors:
        return
    lanes = SegmentGrid(lane_ends(world))
    for name, door in world.doors.items():
        if distance(*door.at) > SAME_PLACE and lanes.first_crossing(*door.at) is None:
            yield warning(("doors", name, "at"), "no lane leads through it", [*map(list, door.at)])


def _check_unique_names(world: World) -> Iterator[Finding]:
    """Yield an error for each door or lift that has the name of another entity."""
    kinds = ("robots", "items", "docks", "doors", "lifts")
    first: dict[str, str] = {}
    for kind in kinds:
        for name in getattr(world, kind):
            other = first.setdefault(name, kind)
            if other != kind and kind in ("doors", "lifts"):
                yield Finding((kind, name), f"{other}.{name} has this name already; choose another", name)


def _check_standing(world: World) -> Iterator[Finding]:
    """Yield an error for each robot that starts in a closed door."""
    closed = [(name, door) for name, door in world.doors.items() if not door.open and distance(*door.at) > SAME_PLACE]
    grid = SegmentGrid([door.at for _, door in closed])
    for other, robot in world.robots.items() if closed else ():
        at = world.find(robot.at)
        if at is None:
            continue
        (x, y), hair = at, 2 * SAME_PLACE
        for name, door in (closed[i] for i in sorted(grid.near((x - hair, y - hair), (x + hair, y + hair)))):
            if distance(at, foot(at, *door.at)) <= SAME_PLACE:
                message = f"({x:g}, {y:g}) is in the closed door {name!r}; start it elsewhere, or open the door"
                yield Finding(("robots", other, "at"), message, robot.at)


def _check_stops(world: World, name: str, lift: Lift, lost: Lost) -> Iterator[Finding]:
    path: Path = ("lifts", name, "stops")
    for i, stop in enumerate(lift.stops):
        if stop not in world.waypoints and not lost.has(stop, "waypoints"):
            yield Finding((*path, i), f"no waypoint {stop!r}{instead(stop, world.waypoints)}", stop)
    for stop, times in Counter(lift.stops).items():
        if times > 1:
            yield Finding(path, f"{stop!r} is listed {times} times; list each stop once", stop)
    for a, b in combinations(dict.fromkeys(stop for stop in lift.stops if stop in world.points), 2):
        if distance(world.points[a], world.points[b]) <= SAME_PLACE:
            yield Finding(path, f"{a!r} and {b!r} are the same point; draw levels beside each other", [a, b])
    if lift.at is not None and lift.at not in lift.stops:
        message = f"{lift.at!r} is not one of its stops{instead(lift.at, lift.stops)}"
        yield Finding(("lifts", name, "at"), message, lift.at)
