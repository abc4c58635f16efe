"""Streets: long rows of lanes with a preferred direction, so that few robots meet head-on.

The directions of parallel streets alternate, as in a town with one-way streets. A direction is only a preference: a
robot drives against it if the detour by the next street would be longer.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from hmrsim.navigation.adjacency import Adjacency

_STRAIGHT = math.cos(math.radians(30))
"""The cosine of the largest angle between two lanes of one street."""

_MIN_LANES = 3
"""The minimum number of lanes of a street."""

_HEADINGS = 4
"""The number of headings into which streets are sorted; parallel streets have the same heading."""


class _Street(NamedTuple):
    """A street with its ways in both directions.

    Attributes:
        heading: The number of its heading.
        offset: The distance to the left of the origin, seen in that heading.
        ways: The numbers of the ways in that heading.
        back: The numbers of the ways in the opposite heading.
    """

    heading: int
    offset: float
    ways: tuple[int, ...]
    back: tuple[int, ...]


def against(ways: Adjacency) -> list[int]:
    """Return the numbers of the ways that lead against their street, in order."""
    streets = sorted(_streets(ways))
    lengths = [math.dist(ways.points[ways.starts[n]], ways.points[ways.ends[n]]) for s in streets for n in s.ways]
    apart = sum(lengths) / max(1, len(lengths)) / 2
    found: list[int] = []
    heading, offset, number = -1, -math.inf, 0
    for street in streets:
        if street.heading != heading:
            heading, number = street.heading, street.heading
        elif street.offset - offset > apart:
            number += 1
        offset = street.offset
        found += street.back if number % 2 else street.ways
    return sorted(found)


def _streets(ways: Adjacency) -> list[_Street]:
    """Return the streets that are long enough and straight on the whole."""
    following = _following(ways)
    found = []
    seen = bytearray(len(ways.ends))
    preceded = bytearray(len(ways.ends))
    for number in following.values():
        preceded[number] = True
    for first in range(len(ways.ends)):
        back = ways.number(ways.ends[first], ways.starts[first])
        if preceded[first] or seen[first] or back < 0:
            # The way does not begin a street, or the street was found from its other end.
            continue
        row, number = [], first
        while number >= 0:
            row.append(number)
            number = following.get(number, -1)
        other = [ways.number(ways.ends[number], ways.starts[number]) for number in row]
        for number in other:
            seen[number] = True
        if len(row) >= _MIN_LANES:
            found += _described(ways, row, other)
    return found


def _following(ways: Adjacency) -> dict[int, int]:
    """Return the way that continues each way straight on, where both can be driven in both directions."""
    best: dict[int, int] = {}
    vectors = _vectors(ways)
    for node in range(len(ways.names)):
        out = [n for n in range(ways.first[node], ways.first[node + 1]) if n not in ways.rides]
        two_way = [(n, back) for n in out if (back := ways.number(ways.ends[n], node)) >= 0]
        pairs = sorted(
            (straight, i, j)
            for i in range(len(two_way))
            for j in range(i)
            if (straight := _cosine(vectors[two_way[i][0]], vectors[two_way[j][0]])) < -_STRAIGHT
        )
        taken: list[int] = []
        for _, i, j in pairs:
            if i not in taken and j not in taken:
                taken += (i, j)
                best[two_way[i][1]] = two_way[j][0]
                best[two_way[j][1]] = two_way[i][0]
    return best


def _vectors(ways: Adjacency) -> list[tuple[float, float]]:
    points = ways.points
    return [
        (points[b][0] - points[a][0], points[b][1] - points[a][1]) for a, b in zip(ways.starts, ways.ends, strict=True)
    ]


def _cosine(a: tuple[float, float], b: tuple[float, float]) -> float:
    return round((a[0] * b[0] + a[1] * b[1]) / ((math.hypot(*a) * math.hypot(*b)) or 1.0), 9)


def _described(ways: Adjacency, row: list[int], other: list[int]) -> list[_Street]:
    """Return the street of these ways and those back, if it is straight on the whole."""
    (ax, ay), (bx, by) = ways.points[ways.starts[row[0]]], ways.points[ways.ends[row[-1]]]
    lengths = (math.dist(ways.points[ways.starts[n]], ways.points[ways.ends[n]]) for n in row)
    if math.dist((ax, ay), (bx, by)) < _STRAIGHT * sum(lengths):
        return []
    angle = math.atan2(by - ay, bx - ax)
    turns = round(angle / math.pi * _HEADINGS)
    heading = turns % _HEADINGS
    if turns % (2 * _HEADINGS) >= _HEADINGS:
        row, other = other, row
    along = heading * math.pi / _HEADINGS
    offset = (ay + by) / 2 * math.cos(along) - (ax + bx) / 2 * math.sin(along)
    return [_Street(heading, offset, tuple(row), tuple(other))]
