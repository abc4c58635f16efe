"""A problem that is easier than the search's: how many moves one robot needs if the others can go anywhere.

Seen from one robot, all others are alike. While it stands at a place, they can arrange themselves as they like in each
part of the lanes that it does not cut off; so all that matters is how many are in each part. Directions of lanes are
ignored for the others, footprints and doors for all. What can't be done here can't be done at all.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache

_Counts = tuple[int, ...]


@dataclass(frozen=True)
class _Parts:
    """The parts into which one robot at a place cuts the lanes.

    Attributes:
        of: By place, the number of its part; -1 where no other robot can be.
        sizes: How many robots have room in each.
    """

    of: tuple[int, ...]
    sizes: tuple[int, ...]


class Relaxation:
    """Distances of one robot to a place, by where it is and how many others are in each part.

    Args:
        ways: By place, where the robot can go from it.
        others: By place, where others can go from it.
        rooms: How many of the others may be at each place.
        target: The place.
        shared: Places that are parts of other ones: of both together only one has a robot.
    """

    def __init__(
        self,
        ways: Sequence[Sequence[int]],
        others: Sequence[Sequence[int]],
        rooms: Sequence[int],
        target: int,
        shared: Mapping[int, int],
    ) -> None:
        self._shared = shared
        self._ways = [frozenset(ends) for ends in ways]
        self._into: list[list[int]] = [[] for _ in others]
        self._out = others
        for start, ends in enumerate(others):
            for end in ends:
                self._into[end].append(start)
        self._joined = [[*dict.fromkeys((*ends, *self._into[at]))] for at, ends in enumerate(others)]
        self._rooms = rooms
        self._target = target
        self._parts = cache(self._find_parts)
        self._shares = cache(self._find_shares)
        self._known: dict[int, dict[tuple[int, _Counts], float]] = {}
        self._next: dict[tuple[int, _Counts], list[tuple[int, _Counts]]] = {}
        self._far = cache(self._find_far)

    def moves(self, here: int, others: Sequence[int]) -> tuple[float, float]:
        """Return how many moves the robot needs at least from a place, where others are; infinite if it can't.

        The second number is about how many moves the others need before the robot can make its next one.
        """
        if self._shared:
            others = [self._shared.get(place, place) for place in others]
            if any(others.count(place) > self._rooms[place] for place in self._shared.values()):
                return 0.0, 0.0
        parts = self._parts(here)
        counts, total = [0] * len(parts.sizes), 0
        for place in others:
            part = parts.of[place]
            if part >= 0:
                counts[part] += 1
                total += 1
            elif self._rooms[place]:
                # It shares the place, or stands where the two touch from the start.
                return 0.0, 0.0
        if total not in self._known:
            self._known[total] = self._find_all(total)
        state = here, tuple(counts)
        left = self._known[total].get(state, math.inf)
        if left in (0.0, math.inf):
            return left, 0.0
        wanted: dict[int, list[_Counts]] = {}
        for end, after in self._next[state]:
            wanted.setdefault(end, []).append(after)
        return left, min(self._effort(here, end, options, others) for end, options in wanted.items())

    def _effort(self, here: int, end: int, options: Sequence[_Counts], others: Sequence[int]) -> float:
        """Return about how many moves others need until so many are in each part after the robot's next move."""
        parts, (to_end, from_end) = self._parts(end), self._far(here, end)
        many = len(parts.sizes)
        there: list[list[float]] = [[] for _ in range(many)]
        taken: dict[int, int] = {}
        at_end = 0
        for place in others:
            taken[place] = taken.get(place, 0) + 1
            if place == end and parts.of[end] < 0:
                at_end += 1
            elif parts.of[place] >= 0:
                there[parts.of[place]].append(to_end[place])
        holes: list[list[float]] = [[] for _ in range(many)]
        for place, part in enumerate(parts.of):
            if part >= 0 and from_end[place] < math.inf:
                room = self._rooms[place] - taken.get(place, 0)
                if room > 0:
                    holes[part] += [from_end[place]] * room
        for row in (*there, *holes):
            row.sort()
        return min(_effort_of(option, there, holes) for option in options)

    def _find_far(self, here: int, end: int) -> tuple[list[float], list[float]]:
        """Return how far it is for others to and from a place, while the robot is at another one."""
        return self._spread(here, end, self._into), self._spread(here, end, self._out)

    def _spread(self, here: int, end: int, ways: Sequence[Sequence[int]]) -> list[float]:
        far = [math.inf] * len(ways)
        far[end], todo = 0.0, deque([end])
        while todo:
            place = todo.popleft()
            for other in ways[place]:
                if far[other] == math.inf and self._rooms[other] - (other == here) > 0:
                    far[other] = far[place] + 1
                    todo.append(other)
        return far

    def _find_all(self, total: int) -> dict[tuple[int, _Counts], float]:
        """Return the distances for so many others, by place and numbers in each part."""
        sizes = self._parts(self._target).sizes
        away: dict[tuple[int, _Counts], float] = {(self._target, counts): 0.0 for counts in _split(total, sizes)}
        todo = deque(away)
        while todo:
            state = todo.popleft()
            for before in self._before(*state):
                if before not in away:
                    away[before] = away[state] + 1
                    todo.append(before)
                if away[before] == away[state] + 1:
                    self._next.setdefault(before, []).append(state)
        return away

    def _before(self, here: int, counts: _Counts) -> Iterator[tuple[int, _Counts]]:
        """Yield from where the robot may have come with one move."""
        for start in self._joined[here]:
            if here in self._ways[start]:
                yield from self._back(here, start, counts)

    def _back(self, here: int, start: int, counts: _Counts) -> Iterator[tuple[int, _Counts]]:
        """Yield how the others may have been before a move; it can be made backwards, as they can."""
        parts, after = self._parts(here), self._parts(start)
        part = parts.of[start]
        if part < 0:
            # Only this robot is ever there.
            inside, size, own = 0, 0, 0
        else:
            inside, size, own = counts[part], parts.sizes[part], self._rooms[start]
        turns = sum(parts.of[place] == part for place in self._joined[here]) > 1
        if own and inside >= size and not turns:
            return
        rest = sum(counts) - inside
        main, shared, others = self._shares(here, start)
        room = shared + (1 if own and turns and inside >= size else 0)
        for split in _splits(inside, [after.sizes[number] for number in others], room):
            new = [0] * len(after.sizes)
            for number, robots in zip(others, split, strict=True):
                new[number] = robots
            left = rest + inside - sum(split)
            if main >= 0:
                new[main] = left
            elif left:
                continue
            yield start, tuple(new)

    def _find_shares(self, here: int, start: int) -> tuple[int, int, tuple[int, ...]]:
        """Return the part in which *here* is once the robot has gone to *start*, and how the part of *start* splits.

        That is how many of the latter's robots have room in the first, and the parts that are cut off from it.
        """
        parts, after = self._parts(here), self._parts(start)
        main = after.of[here]
        part = parts.of[start]
        shared, others = 0, dict[int, None]()
        for place, number in enumerate(parts.of):
            if number != part or number < 0 or after.of[place] < 0:
                continue
            if after.of[place] == main:
                shared += self._rooms[place] - (place == start) - (place == here)
            else:
                others[after.of[place]] = None
        return main, shared, tuple(others)

    def _find_parts(self, here: int) -> _Parts:
        rooms = [room - (place == here) for place, room in enumerate(self._rooms)]
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
        return _Parts(tuple(of), tuple(sizes))


_LONG = 20.0
"""Moves that are assumed where no way leads."""


def _effort_of(wanted: _Counts, there: Sequence[Sequence[float]], holes: Sequence[Sequence[float]]) -> float:
    """Return how many moves it takes until there are so many in each part, by the distances to the place between."""
    effort = 0.0
    for many, robots, free in zip(wanted, there, holes, strict=True):
        change = many - len(robots)
        row = robots[:-change] if change < 0 else free[:change]
        effort += sum(min(away, _LONG) for away in row) + _LONG * (abs(change) - len(row))
    return effort


def _split(total: int, sizes: Sequence[int]) -> Iterator[_Counts]:
    """Yield all ways to put so many robots into parts of these sizes."""
    if not sizes:
        if not total:
            yield ()
        return
    for first in range(min(total, sizes[0]) + 1):
        for rest in _split(total - first, sizes[1:]):
            yield (first, *rest)


def _splits(total: int, sizes: Sequence[int], room: int) -> Iterator[_Counts]:
    """Yield all ways to put robots into parts of these sizes, where at most *room* of them go nowhere."""
    for split in _split_up_to(total, sizes):
        if total - sum(split) <= room:
            yield split


def _split_up_to(total: int, sizes: Sequence[int]) -> Iterator[_Counts]:
    if not sizes:
        yield ()
        return
    for first in range(min(total, sizes[0]) + 1):
        for rest in _split_up_to(total - first, sizes[1:]):
            yield (first, *rest)
