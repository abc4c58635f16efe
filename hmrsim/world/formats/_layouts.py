"""Pages, levels and lanes of files: choosing a page, arranging levels, and joining directed edges to lanes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from hmrsim.errors import Problem, WorldError

if TYPE_CHECKING:
    from hmrsim.world.formats._reading import Part, Reading

_LISTED = 20


def choose_page(names: Sequence[str], wanted: str, file: str, *, noun: str = "page", line: int | None = None) -> int:
    """Return the index of a page by its name or its number from 1; names take precedence.

    Raises:
        WorldError: There is no such page; the message lists the pages.
    """
    if wanted in names:
        return names.index(wanted)
    numbers = [str(i + 1) for i in range(len(names))]
    if wanted in numbers:
        return numbers.index(wanted)
    pages = ", ".join(f"{i} ({name[:40]})" for i, name in enumerate(names[:_LISTED], 1))
    more = f" and {len(names) - _LISTED} more" if len(names) > _LISTED else ""
    raise WorldError([Problem(file, "", f"has no {noun} {wanted[:40]!r}; there are {pages}{more}", line)])


GAP = 5.0
"""Meters between two levels."""


def side_by_side(levels: Sequence[Iterable[complex]]) -> list[float]:
    """Return the shift of each level along x, from the points of each; the first level is not shifted."""
    shifts: list[float] = []
    end: float | None = None
    for points in levels:
        xs = [point.real for point in points]
        shift = end + GAP - min(xs) if end is not None and xs else 0.0
        shifts.append(shift)
        end = max(xs) + shift if xs else end
    return shifts


class Names:
    """Unique names of one kind of entity on all levels.

    Args:
        several: Whether there is more than one level.
        names: The names on each level.
    """

    def __init__(self, names: Sequence[Iterable[str]], *, several: bool) -> None:
        self._several = several
        self._clashing = {
            name for name, count in Counter(name for level in names for name in set(level)).items() if count > 1
        }
        self._taken: set[str] = set()

    def give(self, level: str, own: str, number: str) -> str:
        """Return a unique name: *own* if no other level has it, else with its *level* or as *number*.

        Args:
            level: The name of the level.
            own: The name on that level; empty for none.
            number: The name for an entity without a name, or with one that is taken.
        """
        candidates = [own] if own not in ("", *self._clashing) else []
        candidates += [f"{level}/{own}"] if own else []
        candidates += [f"{level}/{number}" if self._several else number]
        name = next((name for name in candidates if name not in self._taken), candidates[-1])
        while name in self._taken:
            name += "_"
        self._taken.add(name)
        return name


@dataclass
class _Edge:
    part: Part
    limit: float | None
    capacity: int | None
    alone: bool


class Edges:
    """Directed edges between waypoints, which become lanes."""

    def __init__(self, reading: Reading) -> None:
        self._reading = reading
        self._edges: dict[tuple[str, str], _Edge] = {}

    def add(
        self,
        ends: tuple[str, str],
        part: Part,
        *,
        limit: float | None = None,
        capacity: int | None = None,
        alone: bool = False,
    ) -> None:
        """Add an edge; of several with the same ends the fastest counts.

        Args:
            ends: The waypoints at its start and end.
            part: The part of the file.
            limit: The speed limit; None for none.
            capacity: The number of robots that may be on it; None if unknown.
            alone: Whether it must not be joined with its reverse edge to one lane.
        """
        edge = self._edges.get(ends)
        if edge is None:
            self._edges[ends] = _Edge(part, limit, capacity, alone)
            return
        self._reading.leave_out("ways that were there before", part)
        if edge.limit is not None:
            edge.limit = None if limit is None else max(limit, edge.limit)

    def lanes(self) -> list[dict[str, Any]]:
        """Return the lanes, as in a world file; two edges that differ in direction only become one lane."""
        lanes: list[dict[str, Any]] = []
        done: set[tuple[str, str]] = set()
        for (start, end), edge in self._edges.items():
            if (start, end) in done:
                continue
            back = self._edges.get((end, start))
            lane: dict[str, Any] = {"from": start, "to": end}
            if back and not (edge.alone or back.alone) and (edge.limit, edge.capacity) == (back.limit, back.capacity):
                done.add((end, start))
            else:
                lane["one_way"] = True
            if edge.limit is not None:
                lane["speed_limit"] = edge.limit
            if edge.capacity is not None:
                lane["capacity"] = edge.capacity
            self._reading.origin(("lanes", len(lanes)), edge.part)
            lanes.append(lane)
        return lanes
