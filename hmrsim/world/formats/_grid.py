"""Grids of cells as lanes and obstacles."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

Cell = tuple[int, int]
"""Column and row, from 0."""

_STRAIGHT = ((1, 0), (0, 1))
_DIAGONAL = ((1, 1), (-1, 1))
"""Steps to the neighbours that come later; the others have this cell for theirs."""


def steps(rows: Sequence[Sequence[bool]], *, diagonal: bool) -> Iterator[tuple[Cell, Cell]]:
    """Yield pairs of open cells that are neighbours, each once.

    Cells that touch at a corner are neighbours by *diagonal*, if both cells beside are open.
    """
    height = len(rows)
    for y, row in enumerate(rows):
        for x, is_open in enumerate(row):
            if not is_open:
                continue
            for dx, dy in (*_STRAIGHT, *_DIAGONAL) if diagonal else _STRAIGHT:
                to_x, to_y = x + dx, y + dy
                inside = 0 <= to_x < len(row) and to_y < height
                if inside and rows[to_y][to_x] and row[to_x] and rows[to_y][x]:
                    yield (x, y), (to_x, to_y)


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
