"""Lanes without settings as pairs of numbers, for grids with up to a million lanes."""

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
    """Lanes in both directions without settings, as ``[from, to]`` in a world file.

    They are not validated one by one. Their reader ensures that each lane joins two different waypoints of the file,
    and that no two lanes are equal.

    Attributes:
        names: The names of waypoints.
        starts: By lane, the index in *names* of where it begins.
        ends: By lane, the index in *names* of where it ends.
        reach: Upper bound of the lanes' lengths.
        beside: Outlines of obstacles that no lane touches.
    """

    names: Sequence[str]
    starts: array[int]
    ends: array[int]
    reach: float
    beside: AbstractSet[tuple[Point, ...]] = frozenset()

    def __len__(self) -> int:
        """Return the number of lanes."""
        return len(self.starts)

    def __iter__(self) -> Iterator[tuple[str, str]]:
        """Yield the names of each lane's ends, in order."""
        name = self.names.__getitem__
        return zip(map(name, self.starts), map(name, self.ends), strict=True)

    def __getitem__(self, number: int) -> tuple[str, str]:
        """Return the names of a lane's ends."""
        return self.names[self.starts[number]], self.names[self.ends[number]]

    def touched(self) -> list[str]:
        """Return the names of the waypoints that the lanes join, in order."""
        joined = {*self.starts, *self.ends}
        return [name for number, name in enumerate(self.names) if number in joined]
