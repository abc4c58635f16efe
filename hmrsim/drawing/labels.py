"""Placement of labels: each is put beside its mark where there is room, or left out."""

from __future__ import annotations

import itertools
import math
import unicodedata
from collections import defaultdict
from collections.abc import Iterator
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from hmrsim.drawing.frame import Box
    from hmrsim.geometry import Point

_CELL: Final = 32.0
_GAP: Final = 2.0
_STEP: Final = 6.0
_MAX_STEPS: Final = 2000
"""Points that one line is taken for at most."""
_SIDES: Final = (
    *((1, x, y) for x, y in ((1, 0), (-1, 0), (0, -1), (0, 1), (1, -1), (-1, -1), (1, 1), (-1, 1))),
    *((3, x, y) for x, y in ((1, 0), (-1, 0), (0, -1), (0, 1))),
)
"""Where a name may be, in gaps and sides, the better ones first: to the right, to the left, above, below, …"""
_MAX_LETTERS: Final = 28


def shortened(text: str, longest: int = _MAX_LETTERS) -> str:
    """Return a text without its end, if it is long."""
    return text if len(text) <= longest else f"{text[: longest - 1]}…"


def width_of(text: str, size: float) -> float:
    """Return about how wide a line of text is; fonts differ, so it is that of a wide one."""
    wide = sum(unicodedata.east_asian_width(character) in "WF" for character in text)
    return (len(text) * 0.6 + wide * 0.4) * size


class Labels:
    """The occupied parts of a picture.

    No text goes beyond *within*.
    """

    def __init__(self, within: Box) -> None:
        self._within = within
        self._boxes: defaultdict[Point, list[Box]] = defaultdict(list)
        self._lines: defaultdict[Point, list[Point]] = defaultdict(list)

    def block(self, box: Box) -> None:
        """Keep texts out of a box, which may be far larger than the picture."""
        x, y, to_x, to_y = self._within
        seen = max(box[0], x), max(box[1], y), min(box[2], to_x), min(box[3], to_y)
        for cell in _cells(seen):
            self._boxes[cell].append(seen)

    def avoid(self, a: Point, b: Point) -> None:
        """Keep texts off a line where there is another place for them."""
        steps = min(_MAX_STEPS, max(1, int(math.dist(a, b) / _STEP)))
        for step in range(steps + 1):
            x, y = (a[axis] + (b[axis] - a[axis]) * step / steps for axis in (0, 1))
            self._lines[x // _CELL, y // _CELL].append((x, y))

    def place(self, at: Point, radius: float, width: float, height: float) -> Point | None:
        """Return the middle of a text beside a mark of some radius, which is then taken; None if there is no room."""
        best: tuple[int, Box] | None = None
        for far, side_x, side_y in _SIDES:
            aside = radius + far * _GAP
            x, y = at[0] + side_x * (aside + width / 2), at[1] + side_y * (aside + height / 2)
            box = (x - width / 2, y - height / 2, x + width / 2, y + height / 2)
            if not self._free(box):
                continue
            crossed = self._crossed(box)
            if best is None or crossed < best[0]:
                best = crossed, box
            if not crossed:
                break
        if best is None:
            return None
        self.block(best[1])
        x, y, to_x, to_y = best[1]
        return (x + to_x) / 2, (y + to_y) / 2

    def _free(self, box: Box) -> bool:
        x, y, to_x, to_y = self._within
        if box[0] < x or box[1] < y or box[2] > to_x or box[3] > to_y:
            return False
        return not any(_meet(box, other) for cell in _cells(box) for other in self._boxes.get(cell, ()))

    def _crossed(self, box: Box) -> int:
        points = (point for cell in _cells(box) for point in self._lines.get(cell, ()))
        return sum(box[0] <= x <= box[2] and box[1] <= y <= box[3] for x, y in points)


def _cells(box: Box) -> Iterator[Point]:
    xs, ys = (range(int(box[axis] // _CELL), int(box[axis + 2] // _CELL) + 1) for axis in (0, 1))
    return itertools.product(xs, ys)


def _meet(a: Box, b: Box) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]
