"""The checks of facilities: doors and lifts."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator
from itertools import combinations
from typing import TYPE_CHECKING

from hmrsim.diagnostics import Finding, Path, instead, warning
from hmrsim.geometry import SAME_PLACE, distance, foot
from hmrsim.world.model import BUILT_IN_TYPES
from hmrsim.world.segments import SegmentGrid
from hmrsim.world_checks.lanes import lane_ends

if TYPE_CHECKING:
    from hmrsim.world.model import Door, Lift, World
    from hmrsim.world_checks.validation import Lost


def check_fixtures(world: World, lost: Lost) -> Iterator[Finding]:
    """Yield the errors of the doors and lifts of a world."""
    yield from _check_names(world)
    known = dict.fromkeys((*world.robots, *world.robot_types, *BUILT_IN_TYPES))
    for name, door in world.doors.items():
        yield from _check_door(known, name, door, lost)
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
    """Yield a warning for each door through which no lane leads."""
    if lost or not world.doors:
        return
    lanes = SegmentGrid(lane_ends(world))
    for name, door in world.doors.items():
        if distance(*door.at) > SAME_PLACE and lanes.first_crossing(*door.at) is None:
            yield warning(("doors", name, "at"), "no lane leads through it", [*map(list, door.at)])


def _check_names(world: World) -> Iterator[Finding]:
    """Yield an error for each name that another kind of entity that is asked for by name has, too."""
    kinds = ("robots", "items", "docks", "doors", "lifts")
    first: dict[str, str] = {}
    for kind in kinds:
        for name in getattr(world, kind):
            other = first.setdefault(name, kind)
            if other != kind and kind in ("doors", "lifts"):
                yield Finding((kind, name), f"{other}.{name} has this name already; choose another", name)


def _check_door(known: Collection[str], name: str, door: Door, lost: Lost) -> Iterator[Finding]:
    path: Path = ("doors", name)
    if distance(*door.at) <= SAME_PLACE:
        yield Finding((*path, "at"), "has no length: name both its jambs", [*map(list, door.at)])
        return
    for i, opener in enumerate(door.opens_for or ()):
        if opener not in known and not lost.has(opener, "robots", "robot_types"):
            message = f"no robot or robot type {opener!r}{instead(opener, known)}"
            yield Finding((*path, "opens_for", i), message, opener)


def _check_standing(world: World) -> Iterator[Finding]:
    """Yield an error for each robot that starts in a closed door."""
    closed = [(name, door) for name, door in world.doors.items() if not door.open and distance(*door.at) > SAME_PLACE]
    grid = SegmentGrid([door.at for _, door in closed])
    for other, robot in world.robots.items() if closed else ():
        try:
            at = world.point(robot.at)
        except KeyError:
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
