"""Roads of draw.io pages, as waypoints and lanes."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cache
from itertools import combinations, pairwise
from typing import TYPE_CHECKING, Any

from hmrsim.diagnostics import Finding
from hmrsim.geometry import SAME_PLACE, distance, foot
from hmrsim.world.segments import SegmentGrid

if TYPE_CHECKING:
    from hmrsim.geometry import Point
    from hmrsim.world.formats._drawio_cells import Cell
    from hmrsim.world.formats._drawio_drawing import Drawing

JOIN = 20.0
"""Maximum distance of a road's end from another road that it connects to, in px."""

LINK = 100.0
"""Maximum length of a link between parts, in px."""

MAX_PIECES = 2_000
"""Maximum number of straight pieces of all roads, each of which is compared with every other."""

MAX_PARTS = 250

MAX_CROSSINGS = 20_000

_TRIES = 100
"""Maximum number of links between two parts that are checked for walls, the shortest first."""


@dataclass
class _Piece:
    """A straight piece of a road, with the points where other pieces join it."""

    road: int
    start: Point
    end: Point
    joints: list[Point] = field(default_factory=list)
    _box: tuple[float, float, float, float] = field(init=False)

    def __post_init__(self) -> None:
        """Compute the bounding box of the piece."""
        (ax, ay), (bx, by) = self.start, self.end
        self._box = (min(ax, bx), min(ay, by), max(ax, bx), max(ay, by))

    def foot(self, point: Point) -> Point:
        """Return the point of the piece nearest to *point*."""
        return _rounded(foot(point, self.start, self.end))

    def way(self) -> list[Point]:
        """Return all points of the piece, from start to end."""
        inside = set(self.joints) - {self.start, self.end}
        return [self.start, *sorted(inside, key=lambda point: distance(self.start, point)), self.end]

    def may_touch(self, other: _Piece, gap: float = SAME_PLACE) -> bool:
        """Return whether the bounding boxes of both pieces are within *gap* of each other."""
        (left, top, right, bottom), (x0, y0, x1, y1) = self._box, other._box
        return left - gap <= x1 and x0 - gap <= right and top - gap <= y1 and y0 - gap <= bottom


@dataclass(frozen=True)
class Network:
    """Waypoints and lanes, in order of the drawing.

    Attributes:
        points: The waypoints, each with the index of the first road that it is on.
        lanes: The indices of the two waypoints, and of the road that the lane is from.
    """

    points: tuple[tuple[Point, int], ...]
    lanes: tuple[tuple[int, int, int], ...]


def connect(roads: Sequence[Sequence[Point]], clear: Callable[[Point, Point], bool]) -> Network:
    """Return the network of these roads.

    Roads connect where they cross, and where the end of one comes within :data:`JOIN` of another. Parts that
    remain apart and come within :data:`LINK` of each other are linked by their nearest points.

    Args:
        roads: The points of each road, in order.
        clear: Returns whether no wall stands between two points; not called for roads that are drawn.

    Raises:
        ValueError: There are too many.
    """
    builder = _Builder(roads, clear)
    builder.cross()
    builder.join_ends()
    builder.link_parts()
    return builder.network()


class _Builder:
    def __init__(self, roads: Sequence[Sequence[Point]], clear: Callable[[Point, Point], bool]) -> None:
        self._clear = clear
        self._roads = [[_rounded(point) for point in road] for road in roads]
        self._pieces = [_Piece(i, a, b) for i, road in enumerate(self._roads) for a, b in pairwise(road) if a != b]
        if len(self._pieces) > MAX_PIECES:
            raise ValueError(f"{len(self._pieces)} pieces of road; at most {MAX_PIECES}")
        self._meetings: dict[tuple[int, int], list[Point]] = defaultdict(list)
        self._links: list[tuple[Point, Point, int]] = []
        self._part = list(range(len(self._roads)))

    def cross(self) -> None:
        """Connect pieces where they cross or touch.

        Raises:
            ValueError: They do it too often.
        """
        crossings = 0
        for i, piece in enumerate(self._pieces):
            for other in self._pieces[i + 1 :]:
                if piece.may_touch(other):
                    for point in _common(piece, other):
                        piece.joints.append(point)
                        other.joints.append(point)
                        self._meet(piece.road, other.road, point)
                        crossings += 1
            if crossings > MAX_CROSSINGS:
                raise ValueError(f"roads that cross more than {MAX_CROSSINGS} times")

    def _meet(self, road: int, other: int, point: Point) -> None:
        self._meetings[min(road, other), max(road, other)].append(point)
        self._part[self._top(other)] = self._top(road)

    def _top(self, road: int) -> int:
        while self._part[road] != road:
            self._part[road] = self._part[self._part[road]]
            road = self._part[road]
        return road

    def join_ends(self) -> None:
        """Connect the ends of roads to the roads near them, unless they meet there already, nearest first."""
        joins = [
            join
            for i, road in enumerate(self._roads)
            for end in dict.fromkeys((road[0], road[-1]))
            for join in self._near(i, end)
        ]
        for _, road, end, point, piece in sorted(joins, key=lambda join: join[0]):
            met = self._meetings[min(road, piece.road), max(road, piece.road)]
            if all(distance(end, there) > JOIN for there in met) and self._clear(end, point):
                self._link(end, point, piece)
                self._meet(road, piece.road, point)

    def _near(self, road: int, end: Point) -> list[tuple[float, int, Point, Point, _Piece]]:
        """Return the roads near an end: distance, *road*, *end*, the nearest point and its piece."""
        nearest: dict[int, tuple[float, int, Point, Point, _Piece]] = {}
        spot = _Piece(road, end, end)
        for piece in self._pieces:
            if piece.road != road and piece.may_touch(spot, JOIN):
                point = piece.foot(end)
                away = distance(end, point)
                if away <= JOIN and (piece.road not in nearest or away < nearest[piece.road][0]):
                    nearest[piece.road] = (away, road, end, point, piece)
        return list(nearest.values())

    def _link(self, point: Point, joint: Point, piece: _Piece) -> None:
        piece.joints.append(joint)
        if point != joint:
            self._links.append((point, joint, piece.road))

    def link_parts(self) -> None:
        """Link parts by their nearest points without a wall between them.

        Raises:
            ValueError: There are too many parts.
        """
        parts: dict[int, list[_Piece]] = defaultdict(list)
        for piece in self._pieces:
            parts[self._top(piece.road)].append(piece)
        if len(parts) > MAX_PARTS:
            raise ValueError(f"roads in {len(parts)} parts that nothing connects; at most {MAX_PARTS}")
        for one, two in combinations(parts.values(), 2):
            links = [link for a in one for b in two if a.may_touch(b, LINK) for link in _links(a, b)]
            for _, point, joint, piece in sorted(links, key=lambda link: link[:3])[:_TRIES]:
                if self._clear(point, joint):
                    self._link(point, joint, piece)
                    break

    def network(self) -> Network:
        """Return waypoints and lanes in the order in which the roads are drawn, then the links."""
        index: dict[Point, tuple[int, int]] = {}
        lanes: dict[tuple[int, int], int] = {}
        ways = [(a, b, piece.road) for piece in self._pieces for a, b in pairwise(piece.way())]
        for a, b, road in [*ways, *self._links]:
            i, j = (index.setdefault(point, (len(index), road))[0] for point in (a, b))
            if i != j and (j, i) not in lanes:
                lanes.setdefault((i, j), road)
        points = tuple((point, road) for point, (_, road) in index.items())
        return Network(points, tuple((i, j, road) for (i, j), road in lanes.items()))


def _links(one: _Piece, two: _Piece) -> Iterator[tuple[float, Point, Point, _Piece]]:
    """Yield the short links between two pieces: length, an end of one, its foot on the other, and the other."""
    for piece, other in ((one, two), (two, one)):
        for point in (piece.start, piece.end):
            joint = other.foot(point)
            away = distance(point, joint)
            if away <= LINK:
                yield away, point, joint, other


def _rounded(point: Point) -> Point:
    return (round(point[0], 6), round(point[1], 6))


def _common(one: _Piece, two: _Piece) -> Iterator[Point]:
    """Yield the common points of two pieces: their crossing, and ends of one that lie on the other."""
    touching = False
    for piece, ends in ((one, (two.start, two.end)), (two, (one.start, one.end))):
        for point in ends:
            if distance(point, foot(point, piece.start, piece.end)) <= SAME_PLACE:
                touching = True
                yield point
    if touching:
        return
    (ax, ay), (bx, by), (cx, cy), (dx, dy) = one.start, one.end, two.start, two.end
    turn = (bx - ax) * (dy - cy) - (by - ay) * (dx - cx)
    if turn == 0.0:
        return
    along = ((cx - ax) * (dy - cy) - (cy - ay) * (dx - cx)) / turn
    other = ((cx - ax) * (by - ay) - (cy - ay) * (bx - ax)) / turn
    if 0.0 <= along <= 1.0 and 0.0 <= other <= 1.0:
        yield _rounded((ax + along * (bx - ax), ay + along * (by - ay)))


_MAX_COMPARISONS = 1_000_000
"""Maximum number of checks against walls when linking roads."""


def road(drawing: Drawing, cell: Cell) -> None:
    """Read a road: from the center of the shape at its start, along its points, to its end.

    Raises:
        BadCell: An end is not a shape, or a number is invalid.
    """
    source, target = drawing.end(cell, "source"), drawing.end(cell, "target")
    if any(end is not None and end.failed for end in (source, target)):
        return
    points = [*([source.box.center] if source else ()), *cell.points(), *([target.box.center] if target else ())]
    if len(set(points)) < 2:  # noqa: PLR2004
        drawing.warn(cell, "has fewer than two points, so it is not a road")
        return
    drawing.roads.append((cell, points))


def network(drawing: Drawing) -> dict[str, Any]:
    """Return the waypoints and lanes of the roads, as in a world file."""
    try:
        found = connect([points for _, points in drawing.roads], _clear(drawing))
    except ValueError as error:
        drawing.findings.append(Finding(("lanes",), str(error)))
        return {}
    names = _numbered(len(found.points), {*drawing.places, *drawing.robots})
    for name, (_, index) in zip(names, found.points, strict=True):
        drawing.lines["waypoints", name] = drawing.roads[index][0].line
    for i, (_, _, index) in enumerate(found.lanes):
        drawing.lines["lanes", i] = drawing.roads[index][0].line
    return {
        "waypoints": {name: list(point) for name, (point, _) in zip(names, found.points, strict=True)},
        "lanes": [[names[a], names[b]] for a, b, _ in found.lanes],
    }


def _clear(drawing: Drawing) -> Callable[[Point, Point], bool]:
    """Return a function that checks that no wall is between two points; it raises ValueError after too many calls."""
    outlined = [wall["solid"] for wall in drawing.walls]
    sides = [
        ((a[0], a[1]), (b[0], b[1]))
        for outline in outlined
        for a, b in zip(outline, [*outline[1:], outline[0]], strict=True)
    ]
    if not sides:
        return lambda _a, _b: True
    grid = cache(lambda: SegmentGrid(sides))

    def clear(a: Point, b: Point) -> bool:
        if grid().looked > _MAX_COMPARISONS:
            raise ValueError("too many roads near each other with too many walls between; connect the roads")
        return grid().first_crossing(a, b) is None

    return clear


def _numbered(count: int, taken: set[str]) -> list[str]:
    """Return the names n1, n2, … that are not *taken*."""
    names: list[str] = []
    n = 0
    while len(names) < count:
        n += 1
        if f"n{n}" not in taken:
            names.append(f"n{n}")
    return names
