"""The checks of waypoints and lanes."""

from __future__ import annotations

import math
from array import array
from collections.abc import Iterable, Iterator, Sequence
from functools import cached_property
from itertools import chain, islice, pairwise
from typing import TYPE_CHECKING

from hmrsim.diagnostics import Finding, instead, warning
from hmrsim.geometry import SAME_PLACE, distance, foot
from hmrsim.traffic.nearness import near_slots
from hmrsim.traffic.policies import registry as policies
from hmrsim.world.model import PlainLanes
from hmrsim.world.network import Pairs
from hmrsim.world.segments import SegmentGrid, cells_around

if TYPE_CHECKING:
    from hmrsim.diagnostics import Path
    from hmrsim.documents.valid_parts import Lost
    from hmrsim.geometry import Point
    from hmrsim.world.model import Lane, World

_MAX_COMPARISONS = 5_000_000
"""Maximum cost of comparing lanes with walls: some seconds."""

_LISTED = 8
"""Waypoints that a message names of the disconnected parts."""


def check_lanes(world: World, lost: Lost) -> Iterator[Finding]:
    """Yield the errors and warnings of the lanes of a world."""
    lanes = world.lanes
    if isinstance(lanes, PlainLanes) and all(map(world.points.__contains__, lanes.pairs.names)):
        pairs, joined = lanes.pairs, lanes.pairs.touched()
        yield from _check_walls(world, _near_walls(world, pairs))
    else:
        good: list[int] = []
        yield from _check_each(world, lost, good)
        yield from _check_walls(world, good)
        pairs, joined = _pairs(world, good), [name for lane in lanes for name in (lane.from_, lane.to)]
    if lanes and not lost.touches("waypoints", "lanes", "lifts"):
        yield from _check_connected(world, pairs, joined)


def off_the_map(world: World, path: Path, point: Point, severity: str = "error") -> Iterator[Finding]:
    """Yield a finding if a point is outside the bounds of a world."""
    (x, y), (x0, y0, x1, y1) = point, world.bounds or (-math.inf, -math.inf, math.inf, math.inf)
    if x0 < x1 and y0 < y1 and not (x0 <= x <= x1 and y0 <= y <= y1):
        text = f"({x:g}, {y:g}) is outside the map, which spans ({x0:g}, {y0:g}) to ({x1:g}, {y1:g})"
        yield Finding(path, text, [x, y], severity)


def known_lanes(world: World) -> list[Lane]:
    """Return the lanes between known waypoints; the others are reported as errors."""
    points = world.points
    return [lane for lane in world.lanes if lane.from_ in points and lane.to in points]


def lane_ends(world: World) -> list[tuple[Point, Point]]:
    """Return the points at the two ends of each of the `known_lanes`."""
    points = world.points
    return [(points[lane.from_], points[lane.to]) for lane in known_lanes(world)]


class LaneIndex:
    """An index of lanes between known waypoints, for finding those at a point."""

    def __init__(self, world: World, lanes: Sequence[Lane]) -> None:
        self.lanes = lanes
        self._points = world.points

    @cached_property
    def grid(self) -> SegmentGrid:
        """The segments of the lanes."""
        return SegmentGrid([(self._points[lane.from_], self._points[lane.to]) for lane in self.lanes])

    def foot(self, point: Point, i: int) -> Point:
        """Return the nearest point of a lane."""
        lane = self.lanes[i]
        return foot(point, self._points[lane.from_], self._points[lane.to])

    def within(self, point: Point, reach: float) -> list[tuple[float, int]]:
        """Return the distances and indices of the lanes within reach of a point, the nearest first."""
        near = ((distance(point, self.foot(point, i)), i) for i in self.grid.within(point, reach))
        return sorted((away, i) for away, i in near if away <= reach)

    def lanes_at(self, point: Point) -> list[int]:
        """Return the indices of the lanes at a point, in order."""
        return sorted(i for _, i in self.within(point, SAME_PLACE))


def _check_each(world: World, lost: Lost, good: list[int]) -> Iterator[Finding]:
    """Yield the errors of lanes one by one, and add the indices of the valid lanes to *good*."""
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


def _pairs(world: World, good: Sequence[int]) -> Pairs:
    """Return the valid lanes as pairs of numbers."""
    number = {name: i for i, name in enumerate(world.waypoints)}
    starts = array("i", (number[world.lanes[i].from_] for i in good))
    ends = array("i", (number[world.lanes[i].to] for i in good))
    return Pairs([*number], starts, ends, math.inf)


def _segment(world: World, i: int) -> tuple[Point, Point]:
    lane = world.lanes[i]
    return world.points[lane.from_], world.points[lane.to]


def _near_walls(world: World, pairs: Pairs) -> list[int]:
    """Return the lanes that may cross a wall, except the walls of their grid."""
    size, cells = cells_around([(a, b) for _, a, b in _walls(world, pairs)], 2.0 * pairs.reach)
    if not cells:
        return []
    points = (world.points[name] for name in pairs.names)
    near = [(math.floor(x / size), math.floor(y / size)) in cells for x, y in points]
    return [i for i, start in enumerate(pairs.starts) if near[start]]


def _walls(world: World, pairs: Pairs | None = None) -> list[tuple[int, Point, Point]]:
    """Return the segments of walls and outlines with their walls' indices, without those that *pairs* never touch."""
    walls: list[tuple[int, Point, Point]] = []
    for i, wall in enumerate(world.walls):
        if isinstance(wall, tuple):
            points = wall
        elif pairs is None or wall.solid not in pairs.beside:
            points = (*wall.solid, wall.solid[0])
        else:
            continue
        walls += [(i, a, b) for a, b in pairwise(points)]
    return walls


def _check_walls(world: World, good: Sequence[int]) -> Iterator[Finding]:
    walls = _walls(world, world.lanes.pairs if isinstance(world.lanes, PlainLanes) else None)
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


def _check_connected(world: World, pairs: Pairs, joined: Iterable[str]) -> Iterator[Finding]:
    """Warn about waypoints without lanes and about disconnected parts; lifts connect parts, too.

    Args:
        world: Where they are.
        pairs: Its lanes, as far as they are right.
        joined: The names of the waypoints that any lane touches.
    """
    stops = [lift.stops for lift in world.lifts.values()]
    touched = {*joined, *chain.from_iterable(stops)}
    for name in world.waypoints:
        if name not in touched:
            yield warning(("waypoints", name), "no lane leads here")
    number = {name: i for i, name in enumerate(pairs.names)} if stops else {}
    rides = [
        (number.setdefault(first, len(number)), number.setdefault(other, len(number)))
        for first, *others in stops
        for other in others
    ]
    part = _parts(max(len(number), len(pairs.names)), chain(zip(pairs.starts, pairs.ends, strict=True), rides))
    # In order of the first lane of each.
    tops = dict.fromkeys(map(part.__getitem__, pairs.starts))
    if len(tops) > 1:
        firsts = (next(start for start in pairs.starts if part[start] == top) for top in islice(tops, _LISTED))
        names = ", ".join(repr(pairs.names[start]) for start in firsts)
        yield warning(("lanes",), f"are {len(tops)} parts that no lane connects, with {names}", len(tops))


def _parts(count: int, joined: Iterable[tuple[int, int]]) -> list[int]:
    """Return for each number the first one of all that are joined with it."""
    part = list(range(count))
    for ends in joined:
        a, b = ends
        while part[a] != a:
            part[a] = a = part[part[a]]
        while part[b] != b:
            part[b] = b = part[part[b]]
        if a < b:
            part[b] = a
        else:
            part[a] = b
    # Each part before this one has its first already.
    for i, before in enumerate(part):
        part[i] = part[before]
    return part


def check_crossings(world: World) -> Iterator[Finding]:
    """Yield a warning for each lane that crosses another, or is closer to it than robots are wide.

    Lanes that share a waypoint don't count, and policies with reservations keep robots apart. The world must have no
    errors.
    """
    policy = policies().get(world.policy)
    if policy is None or policy.rule is not None:
        return
    bases = (world.robot_type(robot).base for robot in world.robots.values())
    radii = sorted(base.radius or 0.0 for base in bases if not base.flies)
    if len(radii) < 2:  # noqa: PLR2004 - no two robots, no meeting
        return
    at = {name: number for number, name in enumerate(world.points)}
    ends = {i: (at[lane.from_], at[lane.to]) for i, lane in enumerate(world.lanes)}
    wide = sum(radii[-2:])
    for i, near in near_slots([*world.points.values()], ends, wide).items():
        later = {j: away for j, away in near.items() if j > i}
        if not later:
            continue
        j, away = next(iter(later.items()))
        lane, other = world.lanes[i], world.lanes[j]
        how, why = "crosses", " without a waypoint"
        if away > SAME_PLACE:
            how, why = f"is {away:.3g} from", f", and two robots need {wide:.3g}"
        more = f" and {len(later) - 1} more" if len(later) > 1 else ""
        yield warning(
            ("lanes", i),
            f"{lane.from_!r}-{lane.to!r} {how} lanes.{j} {other.from_!r}-{other.to!r}{more}{why}: under"
            f" {policy.name!r} robots pass through each other there; 'reserve', 'priority' and 'planned' keep"
            " them apart",
            [lane.from_, lane.to],
        )
