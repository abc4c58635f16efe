"""Which of many segments a line crosses, without looking at all of them."""

from __future__ import annotations

import math
from collections import defaultdict
from typing import TYPE_CHECKING

from hmrsim.geometry import between, crosses, distance

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from hmrsim.geometry import Point

Segment = tuple["Point", "Point"]

_MOST_PIECES = 2_000
"""A long segment is cut into so many pieces at most; cells grow with the longest."""


class SegmentGrid:
    """Segments sorted into square cells.

    Args:
        segments: The segments, at least one.
    """

    def __init__(self, segments: Sequence[Segment]) -> None:
        self._segments = segments
        lengths = [distance(a, b) for a, b in segments]
        mean = math.fsum(lengths) / len(lengths)
        self._size = max(mean, max(lengths) / _MOST_PIECES) or 1.0
        self._cells: dict[tuple[int, int], list[int]] = defaultdict(list)
        for i, (a, b) in enumerate(segments):
            for cell in self._along(a, b):
                self._cells[cell].append(i)

    def first_crossing(self, a: Point, b: Point) -> int | None:
        """Return the least index of the segments that the line from *a* to *b* meets; None for none."""
        if distance(a, b) > self._size * _MOST_PIECES:
            return next((i for i, (c, d) in enumerate(self._segments) if crosses(a, b, c, d)), None)
        near = {i for cell in self._along(a, b) for i in self._cells.get(cell, ())}
        return min((i for i in near if crosses(a, b, *self._segments[i])), default=None)

    def _along(self, a: Point, b: Point) -> Iterator[tuple[int, int]]:
        """Yield the cells around the line from *a* to *b*, each once."""
        pieces = max(1, math.ceil(distance(a, b) / self._size))
        seen: set[tuple[int, int]] = set()
        for i in range(pieces):
            (x0, y0), (x1, y1) = between(a, b, i / pieces), between(a, b, (i + 1) / pieces)
            for x in range(self._cell(min(x0, x1)), self._cell(max(x0, x1)) + 1):
                for y in range(self._cell(min(y0, y1)), self._cell(max(y0, y1)) + 1):
                    if (x, y) not in seen:
                        seen.add((x, y))
                        yield x, y

    def _cell(self, coordinate: float) -> int:
        return math.floor(coordinate / self._size)
