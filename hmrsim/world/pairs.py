"""Lanes without settings, of which a grid has a million: pairs of numbers instead of objects."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from array import array

    from hmrsim.geometry import Point


@dataclass(frozen=True)
class Pairs:
    """Lanes as in a world file, ``[from, to]``, that lead both ways and have no settings.

    They are not checked one by one. The reader that makes them sees to it that they join waypoints of its own, each two
    different points, and no two of them the same.

    Attributes:
        names: The names of waypoints.
        starts: By lane, the index in *names* of where it begins.
        ends: Likewise where it ends.
        reach: Length of the longest, at most.
        beside: Outlines of obstacles that none of them touches.
    """

    names: Sequence[str]
    starts: array[int]
    ends: array[int]
    reach: float
    beside: AbstractSet[tuple[Point, ...]] = frozenset()

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self.starts)

    def __iter__(self) -> Iterator[tuple[str, str]]:
        """Yield the names of the ends of each, in order."""
        name = self.names.__getitem__
        return zip(map(name, self.starts), map(name, self.ends), strict=True)

    def __getitem__(self, number: int) -> tuple[str, str]:
        """Return the names of the ends of one."""
        return self.names[self.starts[number]], self.names[self.ends[number]]

    def touched(self) -> list[str]:
        """Return the names of the waypoints that they join, in order."""
        joined = {*self.starts, *self.ends}
        return [name for number, name in enumerate(self.names) if number in joined]
