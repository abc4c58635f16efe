"""The checks of waypoints and lanes."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import TYPE_CHECKING

from hmrsim.diagnostics import Finding, instead, warning
from hmrsim.geometry import SAME_PLACE, distance
from hmrsim.world.segments import SegmentGrid

if TYPE_CHECKING:
    from hmrsim.geometry import Point
    from hmrsim.world.model import World
    from hmrsim.world_checks.validation import Lost

_MAX_COMPARISONS = 5_000_000
"""Maximum cost of comparing lanes with walls: some seconds."""


def check_lanes(world: World, lost: Lost) -> Iterator[Finding]:
    """Yield the errors and warnings of the lanes of a world."""
    good: list[int] = []
    driven: dict[tuple[str, str], int] = {}
    for i, lane in enumerate(world.lanes):
        unknown = [(key, name) for key, name in (("from", lane.from_), ("to", lane.to)) if name not in world.waypoints]
        for key, name in unknown:
            if not lost.has(name, "waypoints"):
                message = f"no waypoint {name!r}{instead(name, world.waypoints)}"
                yield Finding(("lanes", i, key), message, name)
        if lane.from_ == lane.to:
            yield Finding(("lanes", i), f"leads from {lane.from_!r} to itself; name two waypoints", lane.from_)
            continue
        ways = [(lane.from_, lane.to), (lane.to, lane.from_)][: 1 if lane.one_way else 2]
        twins = [driven[way] for way in ways if way in driven]
        if twins:
            message = f"{lane.from_!r} and {lane.to!r} are joined by lanes.{twins[0]} already; keep one of the two"
            yield Finding(("lanes", i), message, [lane.from_, lane.to])
        driven.update(dict.fromkeys(ways, i))
        if unknown:
            continue
        if distance(world.points[lane.from_], world.points[lane.to]) <= SAME_PLACE:
            message = f"has no length: {lane.from_!r} and {lane.to!r} are the same point"
            yield Finding(("lanes", i), message, [lane.from_, lane.to])
            continue
        good.append(i)
    yield from _check_walls(world, good)
    if not lost:
        yield from _check_connected(world, good)


def _segment(world: World, i: int) -> tuple[Point, Point]:
    lane = world.lanes[i]
    return world.points[lane.from_], world.points[lane.to]


def _check_walls(world: World, good: list[int]) -> Iterator[Finding]:
    walls: list[tuple[int, Point, Point]] = []
    for i, wall in enumerate(world.walls):
        points = wall if isinstance(wall, tuple) else (*wall.solid, wall.solid[0])
        walls += [(i, a, b) for a, b in pairwise(points)]
    if not walls or not good:
        return
    grid = SegmentGrid([(a, b) for _, a, b in walls])
    for i in good:
        if grid.looked > _MAX_COMPARISONS:
            yield warning(("lanes",), f"and walls are too many to compare all; those from lanes.{i} on were not", i)
            return
        hit = grid.first_crossing(*_segment(world, i))
        if hit is not None:
            lane = world.lanes[i]
            message = f"{lane.from_!r}-{lane.to!r} crosses walls.{walls[hit][0]}; a drawn lane is open all the same"
            yield warning(("lanes", i), message, [lane.from_, lane.to])


def _check_connected(world: World, good: list[int]) -> Iterator[Finding]:
    """Warn of waypoints that no lane touches, and of lanes that fall apart; lifts connect, too."""
    if not world.lanes:
        return
    part = {name: name for lane in world.lanes for name in (lane.from_, lane.to)}
    part |= {stop: stop for lift in world.lifts.values() for stop in lift.stops}

    def top(name: str) -> str:
        while part[name] != name:
            part[name] = part[part[name]]
            name = part[name]
        return name

    for name in world.waypoints:
        if name not in part:
            yield warning(("waypoints", name), "no lane leads here")
    for i in good:
        part[top(world.lanes[i].from_)] = top(world.lanes[i].to)
    for lift in world.lifts.values():
        part.update((top(stop), top(lift.stops[0])) for stop in lift.stops)
    tops: dict[str, str] = {}
    for i in good:
        tops.setdefault(top(world.lanes[i].from_), world.lanes[i].from_)
    if len(tops) > 1:
        names = ", ".join(repr(name) for name in list(tops.values())[:8])
        yield warning(("lanes",), f"are {len(tops)} parts that no lane connects, with {names}", len(tops))
