"""The grid maps of the Moving AI benchmarks.

A cell is a meter wide, and its name is its column and row. The file has row 0 at the top; here y points up, so that the
map looks the same.
"""

from __future__ import annotations

import math
import re
from array import array
from collections.abc import Callable, Iterator, Sequence
from itertools import count
from typing import TYPE_CHECKING, Any

from hmrsim.diagnostics import MAX_FINDINGS, Finding, shown, warning
from hmrsim.errors import Problem, WorldError
from hmrsim.world.files import AS_IT_IS, ReadOptions
from hmrsim.world.formats import Document, Format
from hmrsim.world.network import Pairs

if TYPE_CHECKING:
    from hmrsim.diagnostics import Path

Cell = tuple[int, int]
"""Column and row, from 0."""

_BLOCKED = -1
"""The number of cells that are not open."""

_LOOKS = re.compile(r"\A\s*type[ \t]+\w+\s+(height|width)[ \t]+\d+\s+(height|width)[ \t]+\d+\s+map\b")

_HEADER = ("type", "height", "width", "map")

_OPEN, _CLOSED, _WATER = frozenset(".GS"), frozenset("@OTW"), "W"
"""Terrain and swamp, where robots can drive, and out of bounds, trees and water, where they can't."""

_MAX_OPEN = 512 * 512
"""Maximum number of open cells: with 8 neighbors each, these take seconds and 200 MB."""

_MAX_DIGITS = 12
"""Maximum digits of a number."""


def _read(text: str, file: str, options: ReadOptions = AS_IT_IS) -> Document:
    lines = [line.rstrip("\r") for line in text.rstrip().split("\n")]
    findings: list[Finding] = []
    first, width, height = _header(lines, file)
    rows = lines[first:]
    if len(rows) != height:
        message = f"has {len(rows)} rows, but a height of {height}"
        findings.append(Finding(("height",), message, height, line=len(lines)))
    for y, row in enumerate(rows):
        if len(findings) < MAX_FINDINGS and (wrong := _wrong(row, width)):
            findings.append(Finding(("map",), wrong, row, line=first + y + 1))
    count = sum(row.count(cell) for row in rows for cell in _OPEN)
    if count > _MAX_OPEN:
        findings.append(Finding(("map",), f"has {count} cells to drive on; at most {_MAX_OPEN}", count, line=first))
    if findings:
        return Document({}, findings=tuple(findings), complete=False, grid=True)
    if water := sum(row.count(_WATER) for row in rows):
        findings.append(warning(("map",), f"cells of water: {water}; nothing drives there", water))
    data = _world(rows, width, diagonal=options.neighbours != 4)  # noqa: PLR2004
    return Document(data, _line_of(first), tuple(findings), grid=True)


def _header(lines: list[str], file: str) -> tuple[int, int, int]:
    """Return the index of the first row of the map, and its width and height.

    Raises:
        WorldError: The header is not as expected.
    """
    header: dict[str, str] = {}
    for i, line in enumerate(lines[: 2 * len(_HEADER)]):
        key, _, value = line.strip().partition(" ")
        if key and key not in _HEADER:
            break
        header[key] = value.strip()
        if key == "map" and header.get("type") == "octile":
            return i + 1, _size(header, "width", file), _size(header, "height", file)
    raise WorldError([Problem(file, "", "expected the lines `type octile`, `height …`, `width …` and `map`", 1)])


def _size(header: dict[str, str], key: str, file: str) -> int:
    text = header.get(key, "")
    if not (text.isdecimal() and text.isascii() and len(text) <= _MAX_DIGITS and int(text) > 0):
        raise WorldError([Problem(file, key, f"expected a whole number above 0, got {shown(text)}", 1)])
    return int(text)


def _wrong(row: str, width: int) -> str:
    """Return the error of a row, or an empty text."""
    if len(row) != width:
        return f"has a row of {len(row)} cells, but a width of {width}"
    strange = row.strip("".join(_OPEN | _CLOSED))
    if not strange:
        return ""
    return f"has {strange[0]!r} in column {row.index(strange[0])}; expected one of . G S @ O T W"


def _world(rows: list[str], width: int, *, diagonal: bool) -> dict[str, Any]:
    """Return a grid as in a world file: waypoints in its open cells, obstacles elsewhere."""
    height = len(rows)
    cells = [[cell in _OPEN for cell in row] for row in rows]
    xs, ys = [x + 0.5 for x in range(width)], [height - y - 0.5 for y in range(height)]
    waypoints = {f"{x}_{y}": (xs[x], ys[y]) for y, row in enumerate(cells) for x, is_open in enumerate(row) if is_open}
    columns, levels = [float(x) for x in range(width + 1)], [float(height - y) for y in range(height + 1)]
    outlines = [
        ((columns[x0], levels[y1]), (columns[x1], levels[y1]), (columns[x1], levels[y0]), (columns[x0], levels[y0]))
        for (x0, y0), (x1, y1) in blocks(cells)
    ]
    starts, ends = steps(numbered(cells), diagonal=diagonal)
    return {
        "bounds": [0.0, 0.0, float(width), float(height)],
        "waypoints": waypoints,
        "lanes": Pairs([*waypoints], starts, ends, reach=math.sqrt(2.0), beside=frozenset(outlines)),
        "walls": [{"solid": outline} for outline in outlines],
    }


def _line_of(first: int) -> Callable[[Path], int | None]:
    """Return a function that returns the line of a cell by its name."""

    def line(path: Path) -> int | None:
        if path[:1] == ("waypoints",) and len(path) > 1:
            return first + int(str(path[1]).partition("_")[2]) + 1
        return first

    return line


def numbered(rows: Sequence[Sequence[bool]]) -> list[list[int]]:
    """Return the number of each open cell, row by row."""
    numbers = count()
    return [[next(numbers) if is_open else _BLOCKED for is_open in row] for row in rows]


def steps(rows: Sequence[list[int]], *, diagonal: bool) -> tuple[array[int], array[int]]:
    """Return pairs of neighboring open cells by their numbers, each pair once, in two arrays.

    With *diagonal*, cells that touch at a corner are neighbors if both cells beside them are open. Pairs are ordered by
    their first cell, which is the one with the lower number.
    """
    starts, ends = array("i"), array("i")

    def join(cell: int, other: int) -> None:
        starts.append(cell)
        ends.append(other)

    for row, below in zip(rows, [*rows[1:], [_BLOCKED] * len(rows[0])], strict=True):
        west, east = [_BLOCKED, *row], [*row[1:], _BLOCKED]
        south_west, south_east = [_BLOCKED, *below], [*below[1:], _BLOCKED]
        for cell, w, e, s, sw, se in zip(row, west, east, below, south_west, south_east, strict=False):
            if cell == _BLOCKED:
                continue
            if e != _BLOCKED:
                join(cell, e)
            if s != _BLOCKED:
                join(cell, s)
                if diagonal and _BLOCKED not in (e, se):
                    join(cell, se)
                if diagonal and _BLOCKED not in (w, sw):
                    join(cell, sw)
    return starts, ends


def blocks(rows: Sequence[Sequence[bool]]) -> Iterator[tuple[Cell, Cell]]:
    """Yield rectangles that cover the cells that are not open, each as its first cell and the one after its last.

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
    """Yield the start and end of each run of cells that are not open."""
    begin: int | None = None
    for x, is_open in enumerate([*row, True]):
        if not is_open and begin is None:
            begin = x
        elif is_open and begin is not None:
            yield begin, x
            begin = None


FORMAT = Format(name="movingai", suffixes=(".map",), matches=lambda text: bool(_LOOKS.match(text)), read=_read)
