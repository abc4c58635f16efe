"""The lanes from the view of one robot, which cuts them into parts wherever it is."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

Counts = tuple[int, ...]
"""The number of robots in each part."""


@dataclass(frozen=True)
class Parts:
    """The parts into which a robot at one place cuts the lanes.

    Attributes:
        of: By place, the number of its part; -1 where no other robot can be.
        sizes: How many robots have room in each.
    """

    of: tuple[int, ...]
    sizes: tuple[int, ...]


class _Shares(NamedTuple):
    """The change of the parts when the robot is at its start instead of at the end of a move.

    Attributes:
        main: The part in which the end is; -1 if no other robot can be there.
        room: How many robots of the part of the start have room in it.
        cut: The other parts into which that part splits.
        same: By part, but for that of the start, in which part it is then.
        sizes: The sizes of *cut*.
    """

    main: int
    room: int
    cut: tuple[int, ...]
    same: tuple[int, ...]
    sizes: tuple[int, ...]


class Opening(NamedTuple):
    """The change of the parts when a robot leaves its spot.

    Attributes:
        inside: By part then, which parts it was before.
        rooms: The sizes of these.
        exits: To which parts the robot can go, and by which of those before; -1 for a place that was none's.
        order: By part before, which one it is then, if there are as many as before; else None.
    """

    inside: tuple[tuple[int, ...], ...]
    rooms: tuple[tuple[int, ...], ...]
    exits: tuple[tuple[int, tuple[int, ...]], ...]
    order: tuple[int, ...] | None


class Layer:
    """The lanes while some spots are occupied.

    Args:
        ways: By place, where the robot can go from it.
        others: By place, where others can go from it.
        rooms: How many of the others may be at each place.
        exits: Where the robot at each taken spot can go.
    """

    def __init__(
        self,
        ways: Sequence[Sequence[int]],
        others: Sequence[Sequence[int]],
        rooms: Sequence[int],
        exits: Mapping[int, Sequence[int]],
    ) -> None:
        self.rooms = rooms
        self.exits = exits
        self._ways = ways
        self._out = others
        self._parts: dict[int, Parts] = {}
        self._shares: dict[tuple[int, int], _Shares] = {}
        self._openings: dict[tuple[int, int], Opening] = {}
        self._far: dict[tuple[int, int, bool], list[float]] = {}

    @cached_property
    def _from(self) -> list[list[int]]:
        return _reversed(self._ways)

    @cached_property
    def _into(self) -> list[list[int]]:
        return _reversed(self._out)

    @cached_property
    def _joined(self) -> list[list[int]]:
        return [[*dict.fromkeys((*ends, *self._into[at]))] for at, ends in enumerate(self._out)]

    def parts(self, here: int) -> Parts:
        """Return the parts into which the robot cuts the lanes."""
        if here not in self._parts:
            self._parts[here] = self._find_parts(here)
        return self._parts[here]

    def counts(self, here: int, others: Sequence[int]) -> Counts:
        """Return the number of other robots in each part."""
        parts = self.parts(here)
        counts = [0] * len(parts.sizes)
        for place in others:
            if parts.of[place] >= 0:
                counts[parts.of[place]] += 1
        return tuple(counts)

    def before(self, here: int, counts: Counts) -> Iterator[tuple[int, Counts]]:
        """Yield the places from which the robot can have come in one move, and the numbers in each part then."""
        for start in self._from[here]:
            for before in self._back(here, start, counts):
                yield start, before

    def _back(self, here: int, start: int, counts: Counts) -> Iterator[Counts]:
        parts, after = self.parts(here), self.parts(start)
        part = parts.of[start]
        if part < 0:
            # Only this robot is ever there.
            inside, size, own = 0, 0, 0
        else:
            inside, size, own = counts[part], parts.sizes[part], self.rooms[start]
        turns = sum(parts.of[place] == part for place in self._joined[here]) > 1
        if own and inside >= size and not turns:
            return
        shares = self._shared(here, start)
        main, shared, others, same, _ = shares
        # Where the robot is part of a full ring, the robot behind it follows.
        room = shared + (1 if own and turns else 0)
        rest = [0] * len(after.sizes)
        for number, robots in enumerate(counts):
            if number != part:
                rest[same[number]] += robots
        for split in _up_to(inside, shares.sizes):
            left = inside - sum(split)
            if left > room or (left and main < 0):
                continue
            new = [*rest]
            for number, robots in zip(others, split, strict=True):
                new[number] = robots
            if left:
                new[main] += left
            yield tuple(new)

    def _shared(self, here: int, start: int) -> _Shares:
        """Return the change of the parts when the robot moves from *start* to *here*, in reverse."""
        if (here, start) not in self._shares:
            self._shares[here, start] = self._find_shared(here, start)
        return self._shares[here, start]

    def _find_shared(self, here: int, start: int) -> _Shares:
        parts, after = self.parts(here), self.parts(start)
        main = after.of[here]
        part = parts.of[start]
        shared, others, same = 0, dict[int, None](), [-1] * len(parts.sizes)
        for place, number in enumerate(parts.of):
            if number < 0 or after.of[place] < 0:
                continue
            if number != part:
                same[number] = after.of[place]
            elif after.of[place] == main:
                shared += self.rooms[place] - (place == start) - (place == here)
            else:
                others[after.of[place]] = None
        return _Shares(main, shared, tuple(others), tuple(same), tuple(after.sizes[number] for number in others))

    def opening(self, spot: int, after: Layer, here: int) -> Opening:
        """Return the change of the parts when a robot leaves its spot, which leads to another layer."""
        if (spot, here) not in self._openings:
            self._openings[spot, here] = self._find_opening(spot, after.parts(here), self.parts(here))
        return self._openings[spot, here]

    def _find_opening(self, spot: int, after: Parts, before: Parts) -> Opening:
        order = [after.of[before.of.index(number)] for number in range(len(before.sizes))]
        inside: list[list[int]] = [[] for _ in after.sizes]
        for number, part in enumerate(order):
            inside[part].append(number)
        exits: dict[int, dict[int, None]] = {}
        for end in self.exits[spot]:
            if after.of[end] >= 0:
                exits.setdefault(after.of[end], {})[before.of[end]] = None
        same = len(order) == len(after.sizes) and before.sizes == tuple(after.sizes[number] for number in order)
        return Opening(
            tuple(map(tuple, inside)),
            tuple(tuple(before.sizes[number] for number in numbers) for numbers in inside),
            tuple((part, tuple(ends)) for part, ends in exits.items()),
            tuple(order) if same else None,
        )

    def _find_parts(self, here: int) -> Parts:
        rooms = [room - (place == here) for place, room in enumerate(self.rooms)]
        of, sizes = [-1] * len(rooms), list[int]()
        for first, room in enumerate(rooms):
            if room <= 0 or of[first] >= 0:
                continue
            of[first], todo, size = len(sizes), [first], 0
            while todo:
                place = todo.pop()
                size += rooms[place]
                for end in self._joined[place]:
                    if rooms[end] > 0 and of[end] < 0:
                        of[end] = len(sizes)
                        todo.append(end)
            sizes.append(size)
        return Parts(tuple(of), tuple(sizes))

    def distances(self, here: int, place: int, *, to: bool) -> list[float]:
        """Return the distance of others to or from a place while the robot is at another one."""
        key = here, place, to
        if key not in self._far:
            ways, far = self._into if to else self._out, [math.inf] * len(self.rooms)
            far[place], todo = 0.0, deque([place])
            while todo:
                at = todo.popleft()
                for other in ways[at]:
                    if far[other] == math.inf and self.rooms[other] - (other == here) > 0:
                        far[other] = far[at] + 1
                        todo.append(other)
            self._far[key] = far
        return self._far[key]


def _reversed(ways: Sequence[Sequence[int]]) -> list[list[int]]:
    into: list[list[int]] = [[] for _ in ways]
    for start, ends in enumerate(ways):
        for end in ends:
            into[end].append(start)
    return into


@lru_cache(maxsize=100_000)
def _up_to(total: int, sizes: Counts) -> tuple[Counts, ...]:
    """Return all distributions of at most *total* robots over parts of these sizes."""
    if not sizes:
        return ((),)
    most = min(total, sizes[0])
    return tuple((first, *rest) for first in range(most + 1) for rest in _up_to(total - first, sizes[1:]))
