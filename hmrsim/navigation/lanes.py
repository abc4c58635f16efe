"""The lanes of a map with the obstacles around them: the data that planning works on, and that no run changes."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from heapq import heapify, heappop, heappush
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

from hmrsim.caches import LruCache, Memo, exact
from hmrsim.errors import NoRoute
from hmrsim.geometry import MAX_COORDINATE, SAME_PLACE, Point, distance, foot
from hmrsim.interfaces.nav2_msgs import ComputePathToPose
from hmrsim.navigation.adjacency import Adjacency, Numbers
from hmrsim.navigation.route import Leg, Route
from hmrsim.world.segments import SegmentGrid

if TYPE_CHECKING:
    from hmrsim.world.model import World

T = TypeVar("T")

_KEPT_POINTS = 1_024
"""Points whose nearest lanes are kept."""

_KEPT_FEET = 100_000
"""Nearest points of lanes that are kept, of all points together."""

_KEPT_DERIVED = 32
"""Values that others derive from the lanes, such as a policy for each of its settings."""

_KEPT_LINES = 16_384
"""Points and straight lines, and lanes seen from points, for which it is kept what is in the way."""

_HAIR = 2 * SAME_PLACE
"""Distance from a lane that is looked at more closely."""

_ROUNDING = 1e-9
"""A leg as short as this is a rounding error, for which no robot turns; a thousandth of `SAME_PLACE`."""


class End(NamedTuple):
    """One end of a route, and Nav2's error codes for an end that is invalid."""

    noun: str
    outside: int
    occupied: int


_CODES = ComputePathToPose.Result
START = End("start", _CODES.START_OUTSIDE_MAP, _CODES.START_OCCUPIED)
TARGET = End("target", _CODES.GOAL_OUTSIDE_MAP, _CODES.GOAL_OCCUPIED)


class Foot(NamedTuple):
    """The nearest point of a lane to a point beside it.

    Attributes:
        at: The point.
        number: The lane's.
        away: How far it is from the point beside the lane, in the world's unit.
        along: How far it is from where the lane begins.
        left: How far it is from where the lane ends.
        nearest: Whether it is the nearest point of the lane, so that others are next best if it is hidden.
    """

    at: Point
    number: int
    away: float
    along: float
    left: float
    nearest: bool


@dataclass(frozen=True, slots=True)
class Edge:
    """A lane in one direction.

    Attributes:
        number: Its index among all.
        start: Index of the waypoint where it begins; indices order as names do.
        end: Likewise where it ends.
        leg: All of it, as part of a route.
    """

    number: int
    start: int
    end: int
    leg: Leg


class Lanes:
    """Waypoints and lanes by number, in order of name, so that a number orders as its name does.

    Args:
        world: Where they are. Its names must have been checked.

    Attributes:
        ways: Which waypoints each way joins.
        legs: Each way as a leg.
        edges: The ways of the world by number; numbers order as the names of their ends do.
        driven: The numbers of those that are driven; a robot can enter and leave the others at their ends only.
        out: By waypoint, the edges that begin there.
        into: By waypoint, the edges that end there.
        at: The index of the waypoint at a point; one that no lane touches is a point off the lanes like any other.
        apart: Whether no two of those waypoints are at the same point, so that each lane leads somewhere.
        limited: Whether the quickest route depends on a robot's speed: a lane has a limit, or is a ride.
        points: Where each waypoint is.
        names: Of the waypoints. Their indices are their slots, too, as `hmrsim.traffic.policies` counts them.
        numbers: The numbers of edges, by the names of the waypoints where they begin and end.
    """

    def __init__(self, world: World) -> None:
        self._bounds = world.bounds
        self._walls = world.obstacles()
        # A door off the lanes is a wall for a later position: whether it will be open then is not known.
        self._obstacles = world.obstacles(doors=True) if world.doors else self._walls
        self.ways = ways = Adjacency(world)
        self.names, self.points, self.numbers = ways.names, ways.points, Numbers(ways)
        # Few of them are ever driven.
        self.legs = Memo(partial(_leg, ways))
        self.edges = Memo(partial(_edge, ways, self.legs))
        self.driven: Sequence[int] = range(len(ways.ends))
        if ways.rides:
            self.driven = [number for number in self.driven if number not in ways.rides]
        self.out = Memo(partial(_out, ways, self.edges))
        self.into = Memo(partial(_into, ways, self.edges))
        entered = set(ways.ends)
        touched = [
            node for node in range(len(ways.names)) if ways.first[node] < ways.first[node + 1] or node in entered
        ]
        self.at = {ways.points[node]: node for node in touched}
        self.apart = len(self.at) == len(touched)
        self.limited = bool(ways.limits or ways.rides)
        self._kept_nearest: LruCache[Point, tuple[float, set[tuple[int, int]]]] = LruCache(_KEPT_POINTS)
        points = min(_KEPT_POINTS, _KEPT_FEET // max(1, len(self.driven)))
        self._kept_feet: LruCache[Point, tuple[bool, Mapping[int, Foot]]] = LruCache(points)
        self._kept_occupied: LruCache[Point, bool] = LruCache(_KEPT_LINES)
        self._kept_clear: LruCache[tuple[Point, Point], bool] = LruCache(_KEPT_LINES)
        self._kept_blocked: LruCache[tuple[Point, Point], bool] = LruCache(_KEPT_LINES)
        self._kept_crossed: LruCache[tuple[Point, Point], list[Edge]] = LruCache(_KEPT_POINTS)
        self._kept_seen: LruCache[tuple[Point, int], Sequence[Foot]] = LruCache(_KEPT_LINES)
        self._kept_entrances: LruCache[bytes, tuple[float, Point]] = LruCache(_KEPT_POINTS)
        self._derived: LruCache[Hashable, Any] = LruCache(_KEPT_DERIVED)

    @cached_property
    def tracks(self) -> list[tuple[str, str]]:
        """The lanes without regard to direction, by the names of their ends; their slots follow those of waypoints."""
        ways = self.ways
        ends = (sorted((ways.starts[number], ways.ends[number])) for number in ways.tracks[1])
        return [(self.names[a], self.names[b]) for a, b in ends]

    def derived(self, key: Hashable, make: Callable[[], T]) -> T:
        """Return a cached value that depends on the lanes and *key* only; callers must not change it."""
        value: T = self._derived.get(key, make)
        return value

    def segment(self, number: int) -> tuple[Point, Point]:
        """Return the points at the beginning and the end of a way."""
        ways = self.ways
        return ways.points[ways.starts[number]], ways.points[ways.ends[number]]

    @cached_property
    def _grid(self) -> SegmentGrid:
        return SegmentGrid([self.segment(number) for number in self.driven])

    def driven_near(self, point: Point, reach: float) -> list[Edge]:
        """Return the driven edges around a point, in order: all that are within *reach*, and some farther away."""
        return [self.edges[self.driven[i]] for i in sorted(self._grid.within(point, reach))]

    def crossed_by(self, a: Point, b: Point) -> list[Edge]:
        """Return the driven edges that a straight line meets, in order."""
        return self._kept_crossed.get((a, b), lambda: [self.edges[self.driven[i]] for i in self._grid.crossings(a, b)])

    def check(self, point: Point, end: End = TARGET) -> None:
        """Check that a robot can be at *point*.

        Raises:
            NoRoute: It is outside the map or inside an obstacle; with the codes of that *end* of a route.
        """
        x, y = point
        noun, outside, occupied = end
        if max(abs(x), abs(y)) > MAX_COORDINATE:
            raise NoRoute(outside, f"{noun} ({x:g}, {y:g}) is outside any map: coordinates end at {MAX_COORDINATE:g}")
        if self._bounds is not None:
            x0, y0, x1, y1 = self._bounds
            if not (x0 <= x <= x1 and y0 <= y <= y1):
                raise NoRoute(
                    outside,
                    f"{noun} ({x:g}, {y:g}) is outside the map, which spans ({x0:g}, {y0:g}) to ({x1:g}, {y1:g})",
                )
        if self._kept_occupied.get(point, lambda: self._walls.occupy(point)):
            raise NoRoute(occupied, f"{noun} ({x:g}, {y:g}) is inside an obstacle")

    def clear(self, a: Point, b: Point) -> bool:
        """Return whether nothing ever stands on the straight line from *a* to *b*: no wall, and no door."""
        return self._kept_clear.get((a, b), lambda: not self._obstacles.block(a, b))

    def free(self, a: Point, b: Point) -> float:
        """Return the share of the straight line from *a* to *b* that is free of walls."""
        return self._walls.free(a, b)

    def blocked(self, a: Point, b: Point) -> bool:
        """Return whether a wall stands on the straight line from *a* to *b*."""
        return self._kept_blocked.get((a, b), lambda: self._walls.block(a, b))

    def share_on_map(self, a: Point, b: Point) -> float:
        """Return the share of the line from *a*, which is on the map, to *b* that is on it, too."""
        x0, y0, x1, y1 = self._bounds or (-MAX_COORDINATE, -MAX_COORDINATE, MAX_COORDINATE, MAX_COORDINATE)
        shares = [1.0]
        for start, end, low, high in ((a[0], b[0], x0, x1), (a[1], b[1], y0, y1)):
            if not low <= end <= high:
                shares.append(max(0.0, ((low if end < low else high) - start) / (end - start)))
        return min(shares)

    def edge_between(self, a: Point, b: Point) -> Edge | None:
        """Return the lane or the ride in a lift from *a* to *b*; None if there is none."""
        at, to = self.at.get(a), self.at.get(b)
        ride = -1 if at is None or to is None else self.ways.number(at, to)
        found = [ride] if ride in self.ways.rides else []
        found += [number for number in self._around(a) if self._leads(number, a, b)][:1]
        return self.edges[min(found)] if found else None

    def _leads(self, number: int, a: Point, b: Point) -> bool:
        """Return whether one gets from *a* to *b* on a lane."""
        begin, _ = self.segment(number)
        on_it = all(distance(point, self.foot(point, number)) <= SAME_PLACE for point in (a, b))
        return on_it and distance(begin, a) < distance(begin, b)

    def _around(self, point: Point) -> Iterator[int]:
        """Yield the numbers of driven ways that may lead through a point: most are nowhere near."""
        points, starts, ends = self.points, self.ways.starts, self.ways.ends
        left, right, low, high = point[0] - _HAIR, point[0] + _HAIR, point[1] - _HAIR, point[1] + _HAIR
        for number in self.driven:
            (ax, ay), (bx, by) = points[starts[number]], points[ends[number]]
            if (
                (ax >= left or bx >= left)
                and (ax <= right or bx <= right)
                and (ay >= low or by >= low)
                and (ay <= high or by <= high)
            ):
                yield number

    def leading_to(self, slot: int) -> list[Edge]:
        """Return the edges, in each direction, that a slot belongs to."""
        if slot < len(self.names):
            return self.into[slot]
        number = self.ways.tracks[1][slot - len(self.names)]
        back = self.ways.number(self.ways.ends[number], self.ways.starts[number])
        return [self.edges[way] for way in (number, back) if way >= 0]

    def part(self, edge: Edge, a: Point, b: Point) -> Leg:
        """Return the leg that drives a part of a lane."""
        if edge.leg.ride:
            return edge.leg
        slots = edge.leg.slots if b == edge.leg.end else edge.leg.slots[:1]
        return Leg(a, b, distance(a, b), edge.leg.lane, edge.leg.speed_limit, slots)

    def route(self, legs: Sequence[Leg], goal: Point | None = None) -> Route:
        """Return the route of these legs, without legs of length 0.

        One off the lanes takes the slots of what it ends on: a waypoint, the lane that is driven next with what that
        takes, or any lane. A lane that is left for a point off the lanes also takes that point, so that robots wait for
        it before they are in the way.
        """
        long = [leg for leg in legs if leg.length > _ROUNDING or leg.ride]
        for i in reversed(range(len(long))):
            leg, after = long[i], long[i + 1] if i + 1 < len(long) else None
            if leg.lane is None:
                at = self.at.get(leg.end)
                if at is not None:
                    long[i] = replace(leg, slots=(at,))
                elif after is not None and after.lane is not None:
                    long[i] = replace(leg, slots=after.slots, leaves_for=after.leaves_for, joins=after)
                elif slots := self._track_at(leg.end):
                    long[i] = replace(leg, slots=slots)
            elif after is not None and not after.slots:
                long[i] = replace(leg, leaves_for=after.end)
        return Route(tuple(long), goal)

    def _track_at(self, point: Point) -> tuple[int, ...]:
        """Return the slot of a lane on which a point is; none if it is on none."""
        away, lanes = self.nearest(point)
        if away > SAME_PLACE:
            return ()
        a, b = min(lanes)
        number = self.ways.number(a, b)
        way = number if number >= 0 else self.ways.number(b, a)
        return (len(self.names) + self.ways.tracks[0][way],)

    def nearest(self, point: Point) -> tuple[float, set[tuple[int, int]]]:
        """Return how far the nearest lane is, and all lanes as near as that."""
        return self._kept_nearest.get(point, lambda: self._nearest(point))

    def _nearest(self, point: Point) -> tuple[float, set[tuple[int, int]]]:
        nearest = math.inf
        lanes: set[tuple[int, int]] = set()
        points, starts, ends = self.points, self.ways.starts, self.ways.ends
        left, right = low, high = -math.inf, math.inf
        for number in self.driven:
            start, end = starts[number], ends[number]
            a, b = points[start], points[end]
            if (a[0] < left and b[0] < left) or (a[0] > right and b[0] > right):
                continue
            if (a[1] < low and b[1] < low) or (a[1] > high and b[1] > high):
                continue
            away = distance(point, foot(point, a, b))
            if away < nearest - SAME_PLACE:
                nearest, lanes = away, set()
                left, right = point[0] - away - _HAIR, point[0] + away + _HAIR
                low, high = point[1] - away - _HAIR, point[1] + away + _HAIR
            if away <= nearest + SAME_PLACE:
                lanes.add((min(start, end), max(start, end)))
        return nearest, lanes

    def foot(self, point: Point, number: int) -> Point:
        """Return the point of a lane that is nearest to *point*."""
        return foot(point, *self.segment(number))

    def feet(self, point: Point) -> tuple[bool, list[tuple[Edge, Point]]]:
        """Return whether *point* is on a lane, and the nearest point of each lane that it is on."""
        here = self._on(point)
        return bool(here), [(self.edges[number], at) for number, at in here]

    def approaches(self, point: Point) -> tuple[bool, Mapping[int, Foot]]:
        """Return whether a point is on a lane, and the nearest point of each lane, or only of those that it is on.

        Lanes are identified by their numbers, in order.
        """
        return self._kept_feet.get(point, lambda: self._approaches(point))

    def _approaches(self, point: Point) -> tuple[bool, Mapping[int, Foot]]:
        here = self._on(point)
        feet = here or ((number, self.foot(point, number)) for number in self.driven)
        return bool(here), {number: self._foot(point, number, at, nearest=True) for number, at in feet}

    def _foot(self, beside: Point, number: int, at: Point, *, nearest: bool) -> Foot:
        begin, end = self.segment(number)
        return Foot(at, number, distance(beside, at), distance(begin, at), distance(at, end), nearest)

    def nearest_seen(self, point: Point) -> Point:
        """Return the nearest point of a lane with a clear line of sight to a point, or the point itself.

        That is the point itself where it is on a lane, too.
        """
        return self._nearest_joint(point)[1]

    def away(self, point: Point) -> float:
        """Return the distance to the nearest point of a lane with a clear line of sight; infinite if there is none."""
        return self._nearest_joint(point)[0]

    def _nearest_joint(self, point: Point) -> tuple[float, Point]:
        return self._kept_entrances.get(exact(*point), lambda: self._find_joint(point))

    def _find_joint(self, point: Point) -> tuple[float, Point]:
        if self.approaches(point)[0]:
            return 0.0, point
        foot = next(self.joints(point), [None])[0]
        return (foot.away, foot.at) if foot else (math.inf, point)

    def joints(self, point: Point, skip: Callable[[int], bool] = lambda _number: False) -> Iterator[list[Foot]]:
        """Yield the points of lanes with a clear line of sight to a point, nearest first; equally near ones together.

        These are where robots enter the lanes from the point, and leave them for it. A point on a lane is its own.

        Args:
            point: The point.
            skip: Whether a lane is of no interest, by its number; asked when its turn has come.
        """
        on_lane, feet = self.approaches(point)
        heap = [(foot.away, foot.number, foot) for foot in feet.values()]
        heapify(heap)
        joint: list[Foot] = []
        while heap:
            away, number, foot = heappop(heap)
            if joint and away > joint[0].away + SAME_PLACE:
                yield joint
                joint = []
            if skip(number):
                continue
            if on_lane or self.clear(foot.at, point):
                joint.append(foot)
            else:
                for seen in self.seen(point, foot):
                    heappush(heap, (seen.away, seen.number, seen))
        if joint:
            yield joint

    def _on(self, point: Point) -> list[tuple[int, Point]]:
        """Return the lanes on which a point is, by their numbers, with their points that are nearest to it."""
        feet = ((number, self.foot(point, number)) for number in self._around(point))
        return [(number, at) for number, at in feet if distance(point, at) <= SAME_PLACE]

    def seen(self, eye: Point, hidden: Foot) -> Sequence[Foot]:
        """Return the points of a lane that are visible instead of the nearest one, if that is hidden."""
        if not hidden.nearest:
            return ()
        return self._kept_seen.get((eye, hidden.number), lambda: self._seen(eye, hidden.number))

    def _seen(self, eye: Point, number: int) -> Sequence[Foot]:
        edges = self._obstacles.edges_of_shadow(eye, *self.segment(number))
        return [self._foot(eye, number, at, nearest=False) for at in edges]


def _leg(ways: Adjacency, number: int) -> Leg:
    a, b = ways.starts[number], ways.ends[number]
    start, end, ride = ways.points[a], ways.points[b], ways.rides.get(number, 0.0)
    return Leg(
        start,
        end,
        0.0 if ride else distance(start, end),
        (ways.names[a], ways.names[b]),
        ways.limits.get(number, math.inf),
        (len(ways.names) + ways.tracks[0][number], b),
        ride,
    )


def _edge(ways: Adjacency, legs: Memo[int, Leg], number: int) -> Edge:
    return Edge(number, ways.starts[number], ways.ends[number], legs[number])


def _out(ways: Adjacency, edges: Memo[int, Edge], node: int) -> list[Edge]:
    return [edges[number] for number in range(ways.first[node], ways.first[node + 1])]


def _into(ways: Adjacency, edges: Memo[int, Edge], node: int) -> list[Edge]:
    begins, numbers = ways.into
    return [edges[number] for number in numbers[begins[node] : begins[node + 1]]]
