"""Random lanes: corridors, rings, dead ends and bays on a grid with uneven spacing, sometimes on two floors."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    import random

    from hmrsim.geometry import Point

MARGIN = 6.0
"""Meters from the bounds to the outermost waypoints; places are up to 3 m beside the lanes."""

_SIDE = 9
"""Columns and rows of a grid."""

_SPACINGS = (4.0, 4.0, 5.0, 6.0, 8.0)
"""Meters between two columns or rows."""

_LANE = 3.5
"""Meters between two waypoints of a round cell, and from it to the rest."""

_BAY = 2.0
"""Meters from a waypoint to the bay beside it."""

_DIRECTIONS = ((1, 0), (0, 1), (-1, 0), (0, -1))

_TRIES = 200

Cell = tuple[int, int]


class Lane(NamedTuple):
    """A lane between two named waypoints."""

    start: str
    end: str
    one_way: bool = False


@dataclass
class Layout:
    """The waypoints and lanes of a random world.

    Attributes:
        waypoints: Where each waypoint is, by name.
        lanes: The lanes, in the order in which they were drawn.
        faces: The corners of the rectangles between four neighbors of a grid: left, low, right, high.
        lifts: The stops of each lift, by name.
    """

    waypoints: dict[str, Point] = field(default_factory=dict)
    lanes: list[Lane] = field(default_factory=list)
    faces: list[tuple[float, float, float, float]] = field(default_factory=list)
    lifts: dict[str, tuple[str, str]] = field(default_factory=dict)

    def segment(self, lane: Lane) -> tuple[Point, Point]:
        """Return the two ends of a lane."""
        return self.waypoints[lane.start], self.waypoints[lane.end]

    @property
    def degrees(self) -> Counter[str]:
        """The number of lanes at each waypoint."""
        return Counter(name for lane in self.lanes for name in (lane.start, lane.end))


def random_layout(chance: random.Random, size: int) -> Layout:
    """Return lanes with about *size* waypoints."""
    layout, names = Layout(), Counter[str]()
    two_floors = size >= 12 and chance.random() < 0.2  # noqa: PLR2004 - less is no building
    floors = [size - size // 3, size // 3] if two_floors else [size]
    grids: list[_Grid] = []
    low = 0.0
    for waypoints in floors:
        grid = _Grid(chance, layout, names, low)
        grid.grow(waypoints)
        grids.append(grid)
        low = max(y for _, y in layout.waypoints.values()) + 15.0
    if two_floors:
        layout.lifts["lift"] = (grids[0].add_stub("lift_low"), grids[1].add_stub("lift_high"))
    for grid in grids:
        layout.faces += grid.faces()
    _move(layout)
    return layout


def _move(layout: Layout) -> None:
    """Shift everything so that no coordinate is below the margin."""
    dx = MARGIN - min(x for x, _ in layout.waypoints.values())
    dy = MARGIN - min(y for _, y in layout.waypoints.values())
    layout.waypoints = {name: _rounded(x + dx, y + dy) for name, (x, y) in layout.waypoints.items()}
    layout.faces = [
        (*_rounded(left + dx, low + dy), *_rounded(right + dx, high + dy)) for left, low, right, high in layout.faces
    ]


class _Grid:
    """A floor whose waypoints are cells of a grid.

    Args:
        layout: Where waypoints and lanes are added.
        names: How many waypoints there are of each kind.
        low: The least y.
    """

    def __init__(self, chance: random.Random, layout: Layout, names: Counter[str], low: float) -> None:
        self._chance = chance
        self._layout = layout
        self._names = names
        self._xs = [5.0 + x for x in self._line()]
        self._ys = [low + 5.0 + y for y in self._line()]
        self._at: dict[Cell, str] = {}
        self._joined: dict[frozenset[str], None] = {}
        self._used: dict[tuple[Cell, Cell], None] = {}

    def _line(self) -> list[float]:
        steps, line = self._chance.choices(_SPACINGS, k=_SIDE - 1), [0.0]
        for step in steps:
            line.append(line[-1] + step)
        return line

    def grow(self, size: int) -> None:
        """Add features until there are *size* waypoints."""
        before = len(self._layout.waypoints)
        middle = (_SIDE // 2, _SIDE // 2)
        self._add(middle, "a")
        first = self._chance.choice(("ring", "ring", "corridor", "cell"))
        if first == "ring":
            self._ring(middle)
        elif first == "cell" and size >= 8:  # noqa: PLR2004 - there has to be something beside it
            self._round_cell(middle)
        for _ in range(_TRIES):
            if len(self._layout.waypoints) - before >= size:
                break
            cell = self._chance.choice([*self._at])
            kind = self._chance.choices(("corridor", "stub", "ring", "bay"), (4, 3, 3, 1))[0]
            if kind == "corridor":
                self._corridor(cell, self._chance.randint(2, 4), "c")
            elif kind == "stub":
                self._corridor(cell, 1, "end_")
            elif kind == "ring":
                self._ring(cell)
            else:
                self._bay(cell)

    def add_stub(self, name: str) -> str:
        """Add a dead end of one lane, and return its name."""
        cells = [*self._at]
        self._chance.shuffle(cells)
        for cell in cells:
            for direction in self._chance.sample(_DIRECTIONS, 4):
                to = _beside(cell, direction)
                if self._is_free(to) and (cell, direction) not in self._used:
                    self._add(to, "", name)
                    self._join(self._at[cell], name)
                    return name
        raise AssertionError

    def faces(self) -> Iterator[tuple[float, float, float, float]]:
        """Yield the rectangles between neighboring columns and rows that have a waypoint at a corner."""
        for x in range(_SIDE - 1):
            for y in range(_SIDE - 1):
                if any((x + i, y + j) in self._at for i in (0, 1) for j in (0, 1)):
                    yield self._xs[x], self._ys[y], self._xs[x + 1], self._ys[y + 1]

    def _is_free(self, cell: Cell) -> bool:
        return cell not in self._at and all(0 <= number < _SIDE for number in cell)

    def _point(self, cell: Cell) -> Point:
        return self._xs[cell[0]], self._ys[cell[1]]

    def _name(self, kind: str) -> str:
        self._names[kind] += 1
        return f"{kind}{self._names[kind]}"

    def _add(self, cell: Cell, kind: str, name: str = "") -> str:
        if cell not in self._at:
            self._at[cell] = name = name or self._name(kind)
            self._layout.waypoints[name] = self._point(cell)
        return self._at[cell]

    def _join(self, a: str, b: str, *, one_way: bool = False) -> None:
        if frozenset((a, b)) not in self._joined:
            self._joined[frozenset((a, b))] = None
            self._layout.lanes.append(Lane(a, b, one_way))

    def _use(self, a: Cell, b: Cell) -> None:
        """Record that a lane leaves a cell in a direction, so that no bay is placed there."""
        self._used[a, (b[0] - a[0], b[1] - a[1])] = None
        self._used[b, (a[0] - b[0], a[1] - b[1])] = None

    def _corridor(self, cell: Cell, length: int, kind: str) -> None:
        """Add a straight single track, which sometimes ends in another waypoint."""
        direction = self._chance.choice(_DIRECTIONS)
        for _ in range(length):
            after = _beside(cell, direction)
            if (cell, direction) in self._used or not all(0 <= number < _SIDE for number in after):
                return
            met = after in self._at
            if met and (length == 1 or self._chance.random() < 0.4):  # noqa: PLR2004 - a share
                return
            self._add(after, kind)
            self._join(self._at[cell], self._at[after])
            self._use(cell, after)
            if met:
                return
            cell = after

    def _ring(self, cell: Cell) -> None:
        """Add a rectangle with a corner at a cell, sometimes as a one-way circuit."""
        wide, high = self._chance.choice(((1, 1), (2, 1), (1, 2), (2, 2), (3, 1), (1, 3)))
        left, low = cell[0] - self._chance.choice((0, wide)), cell[1] - self._chance.choice((0, high))
        around = _perimeter(left, low, wide, high)
        if any(not 0 <= number < _SIDE for at in around for number in at):
            return
        sides = [*pairwise([*around, around[0]])]
        if any((a, (b[0] - a[0], b[1] - a[1])) in self._used for a, b in sides):
            return
        one_way = self._chance.random() < 0.25  # noqa: PLR2004 - a share
        for a, b in sides:
            self._join(self._add(a, "r"), self._add(b, "r"), one_way=one_way)
            self._use(a, b)

    def _bay(self, cell: Cell) -> None:
        """Add a bay near a waypoint, where a robot can step aside."""
        direction = self._chance.choice(_DIRECTIONS)
        if (cell, direction) in self._used:
            return
        self._used[cell, direction] = None
        x, y = self._point(cell)
        name = self._name("bay_")
        self._layout.waypoints[name] = (x + _BAY * direction[0], y + _BAY * direction[1])
        self._join(self._at[cell], name)

    def _round_cell(self, cell: Cell) -> None:
        """Add a round ring left of the grid, with dead ends around it, and a lane to a cell."""
        count = self._chance.randint(5, 8)
        radius = _LANE / (2 * math.sin(math.pi / count))
        x, y = self._point(cell)
        x -= radius + self._chance.choice((_LANE, 2 * _LANE))
        one_way = self._chance.random() < 0.6  # noqa: PLR2004 - a share
        ring = [self._name("r") for _ in range(count)]
        for number, name in enumerate(ring):
            angle = math.tau * number / count
            self._layout.waypoints[name] = _rounded(x + radius * math.cos(angle), y + radius * math.sin(angle))
            if number and self._chance.random() < 0.5:  # noqa: PLR2004 - a share
                out = radius + _LANE
                stub = self._name("end_")
                self._layout.waypoints[stub] = _rounded(x + out * math.cos(angle), y + out * math.sin(angle))
                self._join(name, stub)
        for a, b in pairwise([*ring, ring[0]]):
            self._join(a, b, one_way=one_way)
        self._join(ring[0], self._at[cell])
        # The rest of the grid grows to the right of it.
        for column in range(cell[0]):
            for row in range(_SIDE):
                for direction in _DIRECTIONS:
                    self._used[_beside((column, row), direction), (-direction[0], -direction[1])] = None


def _beside(cell: Cell, direction: Cell) -> Cell:
    return cell[0] + direction[0], cell[1] + direction[1]


def _rounded(x: float, y: float) -> Point:
    return round(x, 2), round(y, 2)


def _perimeter(left: int, low: int, wide: int, high: int) -> list[Cell]:
    """Return the cells around a rectangle, counterclockwise."""
    right, top = left + wide, low + high
    return [
        *((x, low) for x in range(left, right)),
        *((right, y) for y in range(low, top)),
        *((x, top) for x in range(right, left, -1)),
        *((left, y) for y in range(top, low, -1)),
    ]
