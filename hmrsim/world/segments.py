"""An index of line segments that finds the segments which a line crosses."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from hmrsim.geometry import between, crosses, distance

if TYPE_CHECKING:
    from hmrsim.geometry import Point

Segment = tuple["Point", "Point"]

_MAX_PIECES = 100_000
"""Approximate maximum number of pieces that the segments are cut into; cells grow with their length."""

_MIN_SIZE = 1e-6

_HAIR = 1e-9
"""Margin of a line as a share of a cell."""

_ROUNDING = 1e-14
"""Further margin of a line for rounding errors, as a share of its coordinates."""


def cells_around(segments: Sequence[Segment], size: float) -> tuple[float, set[tuple[int, int]]]:
    """Return the width of square cells, and the cells with or next to segments, by column and row.

    Cells are at least *size* wide, so that points in other cells are farther than *size* from all segments.
    """
    length = math.fsum(distance(a, b) for a, b in segments)
    size = max(size, length / _MAX_PIECES, _MIN_SIZE)
    found: set[tuple[int, int]] = set()
    for a, b in segments:
        pieces = max(1, math.ceil(distance(a, b) / size))
        for i in range(pieces):
            (x0, y0), (x1, y1) = between(a, b, i / pieces), between(a, b, (i + 1) / pieces)
            columns = range(math.floor(min(x0, x1) / size) - 1, math.floor(max(x0, x1) / size) + 2)
            rows = range(math.floor(min(y0, y1) / size) - 1, math.floor(max(y0, y1) / size) + 2)
            found.update((column, row) for column in columns for row in rows)
    return size, found


class SegmentGrid:
    """Segments sorted into square cells, with about one segment per cell.

    Args:
        segments: The segments.

    Attributes:
        looked: The number of cells and segments that all searches have examined.
    """

    def __init__(self, segments: Sequence[Segment]) -> None:
        self.looked = 0
        self._segments = segments
        xs, ys = ([point[axis] for segment in segments for point in segment] for axis in (0, 1))
        self._low, self._high = (
            (min(xs, default=0.0), min(ys, default=0.0)),
            (max(xs, default=0.0), max(ys, default=0.0)),
        )
        extent = max(self._high[0] - self._low[0], self._high[1] - self._low[1])
        length = math.fsum(distance(a, b) for a, b in segments)
        self._size = max(extent / (2.0 * math.sqrt(max(1, len(segments)))), length / _MAX_PIECES, _MIN_SIZE)
        # The outermost columns and rows that have a segment beside them.
        (left, low), (right, high) = self._low, self._high
        self._columns = self._cell(left) - 1, self._cell(right) + 1
        self._rows = self._cell(low) - 1, self._cell(high) + 1
        self._cells: dict[tuple[int, int], list[int]] = defaultdict(list)
        for i, (a, b) in enumerate(segments):
            for cell in self._along(a, b):
                self._cells[cell].append(i)

    def first_crossing(self, a: Point, b: Point) -> int | None:
        """Return the lowest index of the segments that the line from *a* to *b* meets; None if it meets no segment."""
        return next(iter(self.crossings(a, b)), None)

    def crossings(self, a: Point, b: Point) -> list[int]:
        """Return the indices of the segments that the line from *a* to *b* meets, in order."""
        return sorted([i for i in self.near(a, b) if crosses(a, b, *self._segments[i])])

    def near(self, a: Point, b: Point) -> set[int]:
        """Return the indices of all segments in the cells around the line from *a* to *b*."""
        found: set[int] = set()
        for cell in self._along(*self._clipped(a, b)):
            here = self._cells.get(cell, ())
            found.update(here)
            self.looked += 1 + len(here)
        return found

    def outwards(self, point: Point) -> Iterator[int]:
        """Yield the indices of all segments: first those in the cells around a point, then those farther away."""
        seen: set[int] = set()
        reach = self._size
        while len(seen) < len(self._segments):
            more = self.within(point, reach) - seen
            yield from sorted(more)
            seen |= more
            reach *= 2.0

    def within(self, point: Point, reach: float) -> set[int]:
        """Return the indices of all segments in the cells within *reach* of a point, in x and in y."""
        found: set[int] = set()
        (x, y), size, floor = point, self._size, math.floor
        (left, right), (low, high) = self._columns, self._rows
        rows = range(max(floor((y - reach) / size), low), min(floor((y + reach) / size), high) + 1)
        for column in range(max(floor((x - reach) / size), left), min(floor((x + reach) / size), right) + 1):
            for row in rows:
                found.update(self._cells.get((column, row), ()))
        return found

    def _clipped(self, a: Point, b: Point) -> Segment:
        """Return the part of a line that is near the segments, or one of its ends if there is none."""
        first, last = 0.0, 1.0
        for axis in (0, 1):
            start, way = a[axis], b[axis] - a[axis]
            low, high = self._low[axis] - self._size, self._high[axis] + self._size
            if way:
                enters, leaves = sorted(((low - start) / way, (high - start) / way))
                first, last = max(first, enters), min(last, leaves)
        return (between(a, b, first), between(a, b, last)) if first <= last else (a, a)

    def _along(self, a: Point, b: Point) -> Iterator[tuple[int, int]]:
        """Yield the cells around the line from *a* to *b*, each once."""
        size, floor = self._size, math.floor
        pieces = max(1, math.ceil(distance(a, b) / size))
        seen: set[tuple[int, int]] = set()
        for i in range(pieces):
            (x0, y0), (x1, y1) = between(a, b, i / pieces), between(a, b, (i + 1) / pieces)
            hair = size * _HAIR + _ROUNDING * max(abs(x0), abs(x1), abs(y0), abs(y1))
            rows = range(floor((min(y0, y1) - hair) / size), floor((max(y0, y1) + hair) / size) + 1)
            for x in range(floor((min(x0, x1) - hair) / size), floor((max(x0, x1) + hair) / size) + 1):
                for y in rows:
                    if (x, y) not in seen:
                        seen.add((x, y))
                        yield x, y

    def _cell(self, coordinate: float) -> int:
        return math.floor(coordinate / self._size)
