"""A problem that is easier than the search's: how many moves one robot needs if the others can go anywhere.

Seen from one robot, all others are alike. While it stands at a place, they can arrange themselves as they like in each
part of the lanes that it does not cut off; so all that matters is how many are in each part. Directions of lanes are
ignored for the others. Robots off the waypoints that keep others from driving lanes leave their *spots* one after the
other, and do not come back. What can't be done here can't be done at all.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import product
from typing import NamedTuple

_Counts = tuple[int, ...]


class _State(NamedTuple):
    """Which spots are still taken, where the robot is, and how many others are in each part."""

    spots: tuple[int, ...]
    here: int
    counts: _Counts


@dataclass(frozen=True)
class _Parts:
    """The parts into which one robot at a place cuts the lanes.

    Attributes:
        of: By place, the number of its part; -1 where no other robot can be.
        sizes: How many robots have room in each.
    """

    of: tuple[int, ...]
    sizes: tuple[int, ...]


class TooMuchWork(Exception):
    """The easier problem is too large."""


@dataclass
class Work:
    """How many states may be looked at yet."""

    left: int


class _Shares(NamedTuple):
    """What becomes of the parts once the robot is at its start, and not at the end of a move.

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


class _Opening(NamedTuple):
    """What becomes of the parts once a robot has left its spot.

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
    """The lanes while some spots are taken.

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
        self._parts: dict[int, _Parts] = {}
        self._shares: dict[tuple[int, int], _Shares] = {}
        self._openings: dict[tuple[int, int], _Opening] = {}
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

    def parts(self, here: int) -> _Parts:
        """Return the parts into which the robot cuts the lanes."""
        if here not in self._parts:
            self._parts[here] = self._find_parts(here)
        return self._parts[here]

    def counts(self, here: int, others: Sequence[int]) -> _Counts:
        """Return how many of the others are in each part."""
        parts = self.parts(here)
        counts = [0] * len(parts.sizes)
        for place in others:
            if parts.of[place] >= 0:
                counts[parts.of[place]] += 1
        return tuple(counts)

    def before(self, here: int, counts: _Counts) -> Iterator[tuple[int, _Counts]]:
        """Yield from where the robot may have come with one move, and how many others were in each part then."""
        for start in self._from[here]:
            for before in self._back(here, start, counts):
                yield start, before

    def _back(self, here: int, start: int, counts: _Counts) -> Iterator[_Counts]:
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
        """Return what becomes of the parts once the robot has gone from *start* to *here*, seen backwards."""
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

    def opening(self, spot: int, after: Layer, here: int) -> _Opening:
        """Return what becomes of the parts if a robot leaves its spot, and the layer is another one then."""
        if (spot, here) not in self._openings:
            self._openings[spot, here] = self._find_opening(spot, after.parts(here), self.parts(here))
        return self._openings[spot, here]

    def _find_opening(self, spot: int, after: _Parts, before: _Parts) -> _Opening:
        inside: list[list[int]] = [[] for _ in after.sizes]
        for number in range(len(before.sizes)):
            inside[after.of[before.of.index(number)]].append(number)
        exits: dict[int, dict[int, None]] = {}
        for end in self.exits[spot]:
            if after.of[end] >= 0:
                exits.setdefault(after.of[end], {})[before.of[end]] = None
        order = [after.of[before.of.index(number)] for number in range(len(before.sizes))]
        same = len(order) == len(after.sizes) and before.sizes == tuple(after.sizes[number] for number in order)
        return _Opening(
            tuple(map(tuple, inside)),
            tuple(tuple(before.sizes[number] for number in numbers) for numbers in inside),
            tuple((part, tuple(ends)) for part, ends in exits.items()),
            tuple(order) if same else None,
        )

    def _find_parts(self, here: int) -> _Parts:
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
        return _Parts(tuple(of), tuple(sizes))

    def distances(self, here: int, place: int, *, to: bool) -> list[float]:
        """Return how far it is for others to or from a place, while the robot is at another one."""
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


class Relaxation:
    """Distances of one robot to a place, by where it is and where the others are.

    Args:
        layer: Returns the lanes while some spots are taken.
        target: The place.
        spots: The spots that are taken at first.
        waypoints: How many others are at waypoints at first.
        work: How many states may be looked at yet; it becomes less.
    """

    def __init__(
        self,
        layer: Callable[[tuple[int, ...]], Layer],
        target: int,
        spots: Sequence[int],
        waypoints: int,
        work: Work,
    ) -> None:
        self._work = work
        self._target = target
        self._spots = tuple(sorted(spots))
        self._many = waypoints + len(spots)
        subsets = [
            tuple(spot for spot, taken in zip(self._spots, row, strict=True) if taken)
            for row in product((True, False), repeat=len(self._spots))
        ]
        self._layers = {taken: layer(taken) for taken in subsets}
        self._known: dict[_State, float] = {}
        self._next: dict[_State, list[_State]] = {}
        self._todo: deque[_State] = deque()
        for taken, lanes in self._layers.items():
            if target not in taken:
                for counts in _split(self._many - len(taken), lanes.parts(target).sizes):
                    self._todo.append(_State(taken, target, counts))
        for state in self._todo:
            self._known[state] = 0.0

    def moves(self, here: int, others: Sequence[int]) -> tuple[float, float]:
        """Return how many moves are needed at least with the robot at a place; infinite if it can't get to the target.

        Those are its own and one of each robot that leaves a spot. The second number is about how many moves the
        others need before the next of these.
        """
        spots = tuple(spot for spot in self._spots if spot in others)
        layer = self._layers[spots]
        state = _State(spots, here, layer.counts(here, others))
        if sum(state.counts) + len(spots) != self._many:
            # Two share the place, or stand where they touch from the start.
            return 0.0, 0.0
        left = self._distance(state)
        if left in (0.0, math.inf):
            return left, 0.0
        wanted: dict[int, list[_Counts]] = {}
        effort = math.inf
        for after in self._next[state]:
            if after.here != here:
                wanted.setdefault(after.here, []).append(after.counts)
            else:
                spot = next(spot for spot in spots if spot not in after.spots)
                effort = min(effort, self._leaving(layer, here, spot, others))
        for end, options in wanted.items():
            effort = min(effort, self._arranging(layer, here, end, options, others))
        return left, effort

    def _leaving(self, layer: Layer, here: int, spot: int, others: Sequence[int]) -> float:
        """Return about how many moves others need until a robot can leave its spot."""
        return min(
            (
                away
                for end in layer.exits[spot]
                if end != here
                for place, away in enumerate(layer.distances(here, end, to=False))
                if away < math.inf and max(1, layer.rooms[place]) > others.count(place)
            ),
            default=_LONG,
        )

    def _arranging(self, layer: Layer, here: int, end: int, options: Sequence[_Counts], others: Sequence[int]) -> float:
        """Return about how many moves others need until so many are in each part after the robot's next move."""
        parts, to_end = layer.parts(end), layer.distances(here, end, to=True)
        there: list[list[float]] = [[] for _ in parts.sizes]
        taken: dict[int, int] = {}
        for place in others:
            taken[place] = taken.get(place, 0) + 1
            if parts.of[place] >= 0:
                there[parts.of[place]].append(to_end[place])
        holes: list[list[float]] = [[] for _ in parts.sizes]
        from_end = layer.distances(here, end, to=False)
        for place, part in enumerate(parts.of):
            if part >= 0 and from_end[place] < math.inf:
                room = layer.rooms[place] - taken.get(place, 0)
                if room > 0:
                    holes[part] += [from_end[place]] * room
        for row in (*there, *holes):
            row.sort()
        return min(_effort(option, there, holes) for option in options)

    def _distance(self, state: _State) -> float:
        """Return the distance of a state, by breadth-first search back from the target, as far as it is needed."""
        todo, known = self._todo, self._known
        while todo:
            after = todo[0]
            further = known[after] + 1
            if known.get(state, math.inf) < further:
                break
            if not self._work.left:
                raise TooMuchWork
            self._work.left -= 1
            todo.popleft()
            for before in self._before(after):
                if known.setdefault(before, further) < further:
                    continue
                if before not in self._next:
                    todo.append(before)
                self._next.setdefault(before, []).append(after)
        return known.get(state, math.inf)

    def _before(self, state: _State) -> Iterator[_State]:
        spots, here, counts = state
        for start, before in self._layers[spots].before(here, counts):
            yield _State(spots, start, before)
        for spot in self._spots:
            if spot not in spots and spot != here:
                taken = tuple(sorted((*spots, spot)))
                for before in self._before_leaving(spot, self._layers[spots], self._layers[taken], here, counts):
                    yield _State(taken, here, before)

    def _before_leaving(self, spot: int, after: Layer, before: Layer, here: int, counts: _Counts) -> Iterator[_Counts]:
        """Yield how many others may have been in each part before one left a spot."""
        opening = before.opening(spot, after, here)
        if len(opening.exits) == 1 and opening.order is not None:
            # Nothing else has changed, as nearly always.
            (part, ends), sizes = *opening.exits, before.parts(here).sizes
            if counts[part]:
                new = [counts[number] - (number == part) for number in opening.order]
                if any(end < 0 or new[end] < sizes[end] for end in ends):
                    yield tuple(new)
            return
        yield from dict.fromkeys(self._before_opening(opening, before.parts(here).sizes, counts))

    def _before_opening(self, opening: _Opening, sizes: Sequence[int], counts: _Counts) -> Iterator[_Counts]:
        for part, ends in opening.exits:
            if not counts[part]:
                continue
            splits = (
                _split(count - (number == part), room)
                for number, (count, room) in enumerate(zip(counts, opening.rooms, strict=True))
            )
            for row in product(*splits):
                new = [0] * len(sizes)
                for numbers, split in zip(opening.inside, row, strict=True):
                    for number, robots in zip(numbers, split, strict=True):
                        new[number] = robots
                if any(end < 0 or new[end] < sizes[end] for end in ends):
                    yield tuple(new)


_LONG = 20.0
"""Moves that are assumed where no way leads."""


def _effort(wanted: _Counts, there: Sequence[Sequence[float]], holes: Sequence[Sequence[float]]) -> float:
    """Return how many moves it takes until there are so many in each part, by the distances to the place between."""
    effort = 0.0
    for many, robots, free in zip(wanted, there, holes, strict=True):
        change = many - len(robots)
        row = robots[:-change] if change < 0 else free[:change]
        effort += sum(min(away, _LONG) for away in row) + _LONG * (abs(change) - len(row))
    return effort


def _reversed(ways: Sequence[Sequence[int]]) -> list[list[int]]:
    into: list[list[int]] = [[] for _ in ways]
    for start, ends in enumerate(ways):
        for end in ends:
            into[end].append(start)
    return into


@lru_cache(maxsize=100_000)
def _split(total: int, sizes: _Counts) -> tuple[_Counts, ...]:
    """Return all ways to put so many robots into parts of these sizes."""
    if not sizes:
        return () if total else ((),)
    least, most = max(0, total - sum(sizes[1:])), min(total, sizes[0])
    return tuple((first, *rest) for first in range(least, most + 1) for rest in _split(total - first, sizes[1:]))


@lru_cache(maxsize=100_000)
def _up_to(total: int, sizes: _Counts) -> tuple[_Counts, ...]:
    """Return all ways to put at most so many robots into parts of these sizes."""
    if not sizes:
        return ((),)
    most = min(total, sizes[0])
    return tuple((first, *rest) for first in range(most + 1) for rest in _up_to(total - first, sizes[1:]))
