"""Points, straight lines and the obstacles that they cross.

A point is ``(x, y)`` in the world's unit. No function here depends on the direction of y.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from itertools import chain, pairwise
from types import MappingProxyType
from typing import Final, NamedTuple

Point = tuple[float, float]

MAX_COORDINATE = 1e7
"""The greatest magnitude of a coordinate; beyond it positions would be too coarse to detect an arrival."""

SAME_PLACE = 1e-6
"""Two points that are nearer to each other than this count as the same."""

METER: Final[Mapping[str, float]] = MappingProxyType({"m": 1.0, "px": 80.0})
"""The length of a meter, by the unit of a world: in meters, or in pixels."""


class Pose(NamedTuple):
    """A position in the world's unit of length, and a heading in radians from +x towards +y."""

    x: float
    y: float
    yaw: float = 0.0

    @property
    def point(self) -> Point:
        """The position without the heading."""
        return (self.x, self.y)


def distance(a: Point, b: Point) -> float:
    """Return the length of the straight line from *a* to *b*."""
    return math.hypot(b[0] - a[0], b[1] - a[1])


def heading(a: Point, b: Point) -> float:
    """Return the yaw of a robot that drives from *a* to *b*."""
    return math.atan2(b[1] - a[1], b[0] - a[0])


def turn(yaw: float, to: float) -> float:
    """Return the shortest turn between two yaws, in (-pi, pi]; half a turn is positive."""
    angle = math.remainder(to - yaw, math.tau)
    return math.pi if angle == -math.pi else angle


def yaw_of(z: float, w: float) -> float:
    """Return the yaw of a quaternion that turns about z only; zero if it is all zero."""
    return 2.0 * math.atan2(z, w) if z or w else 0.0


def between(a: Point, b: Point, fraction: float) -> Point:
    """Return the point at a fraction of the way from *a* to *b*; the ends are exact."""
    if fraction <= 0.0:
        return a
    if fraction >= 1.0:
        return b
    return (a[0] + (b[0] - a[0]) * fraction, a[1] + (b[1] - a[1]) * fraction)


def foot(point: Point, a: Point, b: Point) -> Point:
    """Return the point of the segment from *a* to *b* that is nearest to *point*."""
    dx, dy = b[0] - a[0], b[1] - a[1]
    length = dx * dx + dy * dy
    if length == 0.0:
        return a
    return between(a, b, ((point[0] - a[0]) * dx + (point[1] - a[1]) * dy) / length)


def _side(a: Point, b: Point, c: Point) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def crosses(a: Point, b: Point, c: Point, d: Point) -> bool:
    """Return whether the segments *a*-*b* and *c*-*d* meet; touching is meeting."""
    # Most segments are nowhere near each other, and min() and max() take longer than all of this.
    if (
        (a[0] < c[0] and a[0] < d[0] and b[0] < c[0] and b[0] < d[0])
        or (a[0] > c[0] and a[0] > d[0] and b[0] > c[0] and b[0] > d[0])
        or (a[1] < c[1] and a[1] < d[1] and b[1] < c[1] and b[1] < d[1])
        or (a[1] > c[1] and a[1] > d[1] and b[1] > c[1] and b[1] > d[1])
    ):
        return False
    return _side(a, b, c) * _side(a, b, d) <= 0.0 and _side(c, d, a) * _side(c, d, b) <= 0.0


def apart(a: Sequence[float], b: Sequence[float], c: Point, d: Point, room: float) -> bool:
    """Return whether the segments *a*-*b* and *c*-*d* are farther than *room* from each other in x or in y."""
    for i in (0, 1):
        low, high = (c[i], d[i]) if c[i] < d[i] else (d[i], c[i])
        if (a[i] < low - room and b[i] < low - room) or (a[i] > high + room and b[i] > high + room):
            return True
    return False


def gap(a: Point, b: Point, c: Point, d: Point) -> float:
    """Return the distance between the segments *a*-*b* and *c*-*d*; 0 if they meet."""
    if crosses(a, b, c, d):
        return 0.0
    feet = ((a, c, d), (b, c, d), (c, a, b), (d, a, b))
    return min(distance(point, foot(point, start, end)) for point, start, end in feet)


def inside(point: Point, outline: Sequence[Point]) -> bool:
    """Return whether *point* is inside a closed outline (even-odd rule)."""
    x, y = point
    odd = False
    ax, ay = outline[-1]
    for bx, by in outline:
        if (ay > y) != (by > y) and x < (bx - ax) * (y - ay) / (by - ay) + ax:
            odd = not odd
        ax, ay = bx, by
    return odd


_HAIR = 2 * SAME_PLACE
"""Distance that a robot that drives up to a wall keeps from it, so as not to be inside it."""

_EDGE = 1e-6
"""Share of a segment that is kept from the edge of a shadow."""


def _shadow(eye: Point, a: Point, b: Point, c: Point, d: Point) -> tuple[float, float] | None:
    """Return the range of shares of the segment *a*-*b* that the wall *c*-*d* hides from *eye*; None if it hides none.

    In coordinates (p, q) along eye-a and eye-b the sight lines to the segment fill the triangle p, q >= 0, p + q <= 1.
    The wall is clipped to this triangle, and its ends are projected from the eye.
    """
    ax, ay, bx, by = a[0] - eye[0], a[1] - eye[1], b[0] - eye[0], b[1] - eye[1]
    area = ax * by - ay * bx
    if abs(area) <= SAME_PLACE * SAME_PLACE:
        return None
    (p, q), (to_p, to_q) = (
        (((x - eye[0]) * by - (y - eye[1]) * bx) / area, (ax * (y - eye[1]) - ay * (x - eye[0])) / area)
        for x, y in (c, d)
    )
    low, high = 0.0, 1.0
    for start, end in ((p, to_p), (q, to_q), (1.0 - p - q, 1.0 - to_p - to_q)):
        if start < 0.0 and end < 0.0:
            return None
        if start < 0.0:
            low = max(low, start / (start - end))
        elif end < 0.0:
            high = min(high, start / (start - end))
    if low > high:
        return None
    shares = []
    for along in (low, high):
        u, v = p + (to_p - p) * along, q + (to_q - q) * along
        if u + v <= 0.0:
            return 0.0, 1.0
        shares.append(min(1.0, max(0.0, v / (u + v))))
    return min(shares), max(shares)


def _meeting(a: Point, b: Point, c: Point, d: Point) -> float:
    """Return the share of the segment *a*-*b* up to shortly before the wall *c*-*d*; they have to meet."""
    along = (b[0] - a[0]) * (d[1] - c[1]) - (b[1] - a[1]) * (d[0] - c[0])
    if along == 0.0:
        # They are on one line.
        return (distance(a, foot(a, c, d)) - _HAIR) / max(distance(a, b), _HAIR)
    share = ((c[0] - a[0]) * (d[1] - c[1]) - (c[1] - a[1]) * (d[0] - c[0])) / along
    return share - _HAIR * distance(c, d) / abs(along)


class Obstacles:
    """Walls and solids, which block robots off the lanes.

    Args:
        walls: Polylines without thickness.
        solids: Closed outlines that nothing can be inside of.
    """

    def __init__(self, walls: Iterable[Sequence[Point]], solids: Iterable[Sequence[Point]]) -> None:
        self._solids = [tuple(outline) for outline in solids]
        self._segments = [pair for wall in walls for pair in pairwise(wall)]
        self._segments += [
            pair for outline in self._solids for pair in zip(outline, (*outline[1:], outline[0]), strict=True)
        ]

    def occupy(self, point: Point) -> bool:
        """Return whether *point* is on a wall or inside a solid."""
        x, y = point
        near = self._near((x - _HAIR, y - _HAIR), (x + _HAIR, y + _HAIR))
        return self.surround(point) or any(distance(point, foot(point, a, b)) <= SAME_PLACE for a, b in near)

    def surround(self, point: Point) -> bool:
        """Return whether *point* is inside a solid."""
        return any(inside(point, outline) for outline in self._solids)

    def edges_of_shadow(self, eye: Point, a: Point, b: Point) -> list[Point]:
        """Return the points of the segment *a*-*b* at which the shadow around the foot of *eye* ends, on either side.

        There are none if all of the segment is in shadow.
        """
        middle = foot(eye, a, b)
        length = distance(a, b)
        if length == 0.0:
            return []
        at = distance(a, middle) / length
        shadows = sorted(shadow for c, d in self._near(eye, a, b) if (shadow := _shadow(eye, a, b, c, d)))
        # A line that touches a wall is blocked, so the points are a little away from the edges of shadows.
        edge = max(SAME_PLACE / length, _EDGE)
        free, reached = [], 0.0
        for low, high in [*shadows, (1.0, 1.0)]:
            if low - edge > reached:
                free.append((reached, low - edge))
            reached = max(reached, high + edge)
        before = [high for _, high in free if high <= at][-1:]
        after = [low for low, _ in free if low >= at][:1]
        points = [between(a, b, fraction) for fraction in (*before, *after)]
        return [point for point in points if point != middle]

    def free(self, a: Point, b: Point) -> float:
        """Return the share of the straight line from *a* to *b* that is free, which ends shortly before a wall."""
        if self.surround(a):
            return 0.0
        shares = [_meeting(a, b, c, d) for c, d in self._near(a, b) if crosses(a, b, c, d)]
        return max(0.0, min(shares, default=1.0))

    def block(self, a: Point, b: Point) -> bool:
        """Return whether the straight line from *a* to *b* meets a wall or a solid."""
        return any(crosses(a, b, c, d) for c, d in self._near(a, b)) or self.surround(a)

    def _near(self, *points: Point) -> list[tuple[Point, Point]]:
        """Return the walls that overlap the bounding box of some points; this takes only four comparisons per wall."""
        (left, right), (low, high) = ((min(values), max(values)) for values in zip(*points, strict=True))
        return [
            (c, d)
            for c, d in self._segments
            if (c[0] >= left or d[0] >= left)
            and (c[0] <= right or d[0] <= right)
            and (c[1] >= low or d[1] >= low)
            and (c[1] <= high or d[1] <= high)
        ]


class PlaceNames:
    """Finds names for points, such as "dock1" or "near lobby".

    Args:
        named: Points by name. Of several names of a point, the first one is used.
    """

    def __init__(self, *named: Mapping[str, Point]) -> None:
        self._names: dict[Point, str] = {}
        for points in named:
            for name, point in points.items():
                self._names.setdefault(point, name)
        # In squares of a grid, so that finding the names for the positions of a whole fleet takes little time.
        self._squares: dict[tuple[int, int], list[tuple[int, Point, str]]] = {}
        for number, (point, name) in enumerate(self._names.items()):
            self._squares.setdefault(_square(point), []).append((number, point, name))

    def of(self, point: Point) -> str:
        """Return the name of a point, or its coordinates."""
        if point in self._names:
            return self._names[point]
        column, row = _square(point)
        around = [(column + i, row + j) for i in (-1, 0, 1) for j in (-1, 0, 1)]
        named = chain.from_iterable(self._squares.get(square, ()) for square in around)
        near = [(number, name) for number, at, name in named if distance(at, point) <= SAME_PLACE]
        return min(near)[1] if near else f"({point[0]:g}, {point[1]:g})"


def _square(point: Point) -> tuple[int, int]:
    """Return the square of a point, by column and row, in a grid whose squares are as wide as one place."""
    return math.floor(point[0] / SAME_PLACE), math.floor(point[1] / SAME_PLACE)
