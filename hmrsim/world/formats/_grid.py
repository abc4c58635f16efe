"""Grids of cells as lanes and obstacles."""

from __future__ import annotations

from array import array
from collections.abc import Iterator, Sequence
from itertools import count

Cell = tuple[int, int]
"""Column and row, from 0."""

_CLOSED = -1
"""What a closed cell has for a number."""


def numbered(rows: Sequence[Sequence[bool]]) -> list[list[int]]:
    """Return the number of each open cell, row by row."""
    numbers = count()
    return [[next(numbers) if is_open else _CLOSED for is_open in row] for row in rows]


def steps(rows: Sequence[list[int]], *, diagonal: bool) -> tuple[array[int], array[int]]:
    """Return pairs of open cells that are neighbours, by their numbers, each once, in two arrays.

    Cells that touch at a corner are neighbours by *diagonal*, if both cells beside are open. The pairs of a cell with
    those that come later are together; the others have this cell for theirs.
    """
    starts, ends = array("i"), array("i")

    def join(cell: int, other: int) -> None:
        starts.append(cell)
        ends.append(other)

    for row, below in zip(rows, [*rows[1:], [_CLOSED] * len(rows[0])], strict=True):
        west, east = [_CLOSED, *row], [*row[1:], _CLOSED]
        south_west, south_east = [_CLOSED, *below], [*below[1:], _CLOSED]
        for cell, w, e, s, sw, se in zip(row, west, east, below, south_west, south_east, strict=False):
            if cell == _CLOSED:
                continue
            if e != _CLOSED:
                join(cell, e)
            if s != _CLOSED:
                join(cell, s)
                if diagonal and _CLOSED not in (e, se):
                    join(cell, se)
                if diagonal and _CLOSED not in (w, sw):
                    join(cell, sw)
    return starts, ends


def blocks(rows: Sequence[Sequence[bool]]) -> Iterator[tuple[Cell, Cell]]:
    """Yield rectangles that cover the cells that are not open: the first cell, and the one after the last.

    Runs of a row that are just below runs as long are one rectangle with them.
    """
    above: dict[tuple[int, int], int] = {}
    for y, row in enumerate([*rows, ()]):
        here = dict.fromkeys(_runs(row), y)
        for run, begin in above.items():
            if run in here:
                here[run] = begin
            else:
                yield (run[0], begin), (run[1], y)
        above = here


def _runs(row: Sequence[bool]) -> Iterator[tuple[int, int]]:
    """Yield where the cells of a row that are not open begin and end."""
    begin: int | None = None
    for x, is_open in enumerate([*row, True]):
        if not is_open and begin is None:
            begin = x
        elif is_open and begin is not None:
            yield begin, x
            begin = None
