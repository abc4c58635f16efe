"""The geometry of slots: which slots are so near that vehicles on them touch, and how many vehicles fit into each.

Slots are near each other, for example, where lanes cross without a waypoint. Slots that share a waypoint do not count
as neighbors: they always touch, and vehicles follow each other from one to the next.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

from hmrsim.geometry import SAME_PLACE, distance, foot, gap
from hmrsim.world.model import Waypoint

if TYPE_CHECKING:
    from hmrsim.geometry import Point
    from hmrsim.navigation.lanes import Lanes
    from hmrsim.world.model import World

Near = dict[int, dict[int, float]]
"""The neighbors of each slot, in order, with their distances in the world's unit; slots without any are left out."""

_SHIFT = 0.382
"""The share of a cell by which the grid is shifted, so that the lanes of a lattice do not run along its borders."""


class _Shape(NamedTuple):
    """A slot with its ends, and the box around it that contains everything near it."""

    slot: int
    start: int
    end: int
    a: Point
    b: Point
    left: float
    low: float
    right: float
    high: float


def touch(away: float, radii: float) -> bool:
    """Return whether two vehicles can touch, given the distance of their slots and the sum of their *radii*.

    Vehicles without a footprint touch if their slots meet. Vehicles that just fit beside each other do not touch.
    """
    return away < max(SAME_PLACE, radii - SAME_PLACE)


def widest(world: World) -> float:
    """Return the largest sum of the radii of two driving robots of a world, including robots that may be spawned."""
    kinds = [*world.robot_types.values(), *map(world.robot_type, world.robots.values())]
    return 2 * max((kind.base.radius or 0.0 for kind in kinds if not kind.base.flies), default=0.0)


def near_slots(points: Sequence[Point], ends: Mapping[int, tuple[int, int]], reach: float) -> Near:
    """Return the slots that touch without a waypoint in common.

    The time is proportional to the number of slots if they have about the same length, and each is near few others.

    Args:
        points: Where each waypoint is.
        ends: The waypoints at the ends of each slot; the same one twice for a waypoint.
        reach: The greatest sum of two vehicles' radii.
    """
    found: defaultdict[int, dict[int, float]] = defaultdict(dict)
    for inside in _by_cell(points, ends, reach).values():
        _compare(inside, reach, found)
    return {slot: dict(sorted(near.items())) for slot, near in sorted(found.items())}


def comparisons(points: Sequence[Point], ends: Mapping[int, tuple[int, int]], reach: float) -> int:
    """Return the number of pairs of slots that `near_slots` compares for the same arguments."""
    return sum(math.comb(len(inside), 2) for inside in _by_cell(points, ends, reach).values())


def slots_around(lanes: Lanes, point: Point, capacities: Sequence[float], reach: float) -> dict[int, float]:
    """Return the waypoints and lanes near a point, in order, with their distances.

    Lanes through the point are left out, since a robot that stands there holds its lane anyway, and so are slots with
    room for any number of robots.

    Args:
        lanes: The waypoints and lanes.
        point: The point.
        capacities: The number of robots that may hold each slot at once.
        reach: The greatest sum of two vehicles' radii.
    """
    found: dict[int, float] = {}
    for edge in lanes.driven_near(point, max(SAME_PLACE, reach)):
        a, b = lanes.points[edge.start], lanes.points[edge.end]
        away = distance(point, foot(point, a, b))
        if away > SAME_PLACE:
            found[edge.leg.slots[0]] = away
        found[edge.start], found[edge.end] = distance(point, a), distance(point, b)
    return {slot: away for slot, away in sorted(found.items()) if capacities[slot] < math.inf and touch(away, reach)}


def _by_cell(
    points: Sequence[Point], ends: Mapping[int, tuple[int, int]], reach: float
) -> dict[tuple[int, int], list[_Shape]]:
    """Return the shapes in each square cell: slots that touch have a cell in common."""
    margin = max(SAME_PLACE, reach) / 2
    shapes = [_shape(slot, points, two, margin) for slot, two in ends.items()]
    long = [max(shape.right - shape.left, shape.high - shape.low) for shape in shapes if shape.start != shape.end]
    size = max(math.fsum(long) / max(1, len(long)), 2 * margin)
    cells: defaultdict[tuple[int, int], list[_Shape]] = defaultdict(list)
    for shape in shapes:
        for cell in _cells(shape, size, margin):
            cells[cell].append(shape)
    return cells


def _shape(slot: int, points: Sequence[Point], ends: tuple[int, int], margin: float) -> _Shape:
    a, b = points[ends[0]], points[ends[1]]
    (left, right), (low, high) = ((min(values) - margin, max(values) + margin) for values in zip(a, b, strict=True))
    return _Shape(slot, *ends, a, b, left, low, right, high)


def _cells(shape: _Shape, size: float, margin: float) -> Iterator[tuple[int, int]]:
    """Yield each cell that overlaps a box around a piece of a shape, once."""
    (ax, ay), (bx, by) = shape.a, shape.b
    pieces = math.ceil(max(abs(bx - ax), abs(by - ay)) / size) or 1
    seen: set[tuple[int, int]] = set()
    for i in range(pieces):
        first, last = i / pieces, (i + 1) / pieces
        x0, y0, x1, y1 = ax + (bx - ax) * first, ay + (by - ay) * first, ax + (bx - ax) * last, ay + (by - ay) * last
        left, right = _cell(min(x0, x1) - margin, size), _cell(max(x0, x1) + margin, size)
        low, high = _cell(min(y0, y1) - margin, size), _cell(max(y0, y1) + margin, size)
        for x in range(left, right + 1):
            for y in range(low, high + 1):
                if (x, y) not in seen:
                    seen.add((x, y))
                    yield x, y


def _cell(coordinate: float, size: float) -> int:
    return math.floor(coordinate / size + _SHIFT)


def _compare(shapes: Sequence[_Shape], reach: float, found: defaultdict[int, dict[int, float]]) -> None:
    """Add the pairs of slots in a cell that touch to *found*."""
    for number, (one, start, end, a, b, left, low, right, high) in enumerate(shapes):
        for other, from_, to, c, d, other_left, other_low, other_right, other_high in shapes[:number]:
            if other_left > right or other_right < left or other_low > high or other_high < low:
                continue
            if start in (from_, to) or end in (from_, to) or (one in found and other in found[one]):
                continue
            if _far(a, b, c, d, reach) or _far(c, d, a, b, reach):
                continue
            away = gap(a, b, c, d)
            if touch(away, reach):
                found[one][other] = found[other][one] = away


def _far(a: Point, b: Point, c: Point, d: Point, reach: float) -> bool:
    """Return whether a segment *c*-*d* is on one side of the line *a*-*b* and far from it, as most are."""
    dx, dy = b[0] - a[0], b[1] - a[1]
    one, other = dx * (c[1] - a[1]) - dy * (c[0] - a[0]), dx * (d[1] - a[1]) - dy * (d[0] - a[0])
    away = min(one, other) if one > 0.0 else min(-one, -other)
    return away > 0.0 and away > max(SAME_PLACE, reach) * math.hypot(dx, dy)


def rooms_of_waypoints(world: World, default: int | None) -> dict[str, float]:
    """Return the number of vehicles that may be at each waypoint.

    A docked robot stands at the waypoint of its dock, so that the waypoint has the dock's capacity. A robot that waits
    for a lift stands beside the door, and lets others get out.

    Args:
        world: Its waypoints; docks without a place are left out.
        default: The capacity of waypoints that state none; None for any number.
    """
    stated: dict[str, int | None] = {
        name: at.capacity for name, at in world.waypoints.items() if isinstance(at, Waypoint)
    }
    names = {point: name for name, point in world.points.items()}
    for dock in world.docks:
        name, capacity = names.get(_point(world, dock) or (math.nan, math.nan)), world.docks[dock].capacity
        if name is not None and capacity > 1:
            room = stated.get(name) or default
            stated[name] = room and max(room, capacity)
    stops = {stop for lift in world.lifts.values() for stop in lift.stops}
    return {name: stated.get(name) or (None if name in stops else default) or math.inf for name in world.waypoints}


def _point(world: World, dock: str) -> Point | None:
    try:
        return world.dock_point(dock)
    except KeyError:
        return None
