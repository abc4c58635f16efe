"""A relaxation of the search's problem: the number of moves that one robot needs if the others can go anywhere.

All other robots count as equal. While the robot stands at a place, it cuts the lanes into parts in which the others can
rearrange themselves freely, so that only their number in each part matters. They ignore the directions of lanes. Robots
off the waypoints that block lanes leave their *spots* one after the other and don't return. A target that is impossible
in this relaxation is impossible in the world.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import product
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from hmrsim.random_fleets.layers import Counts, Layer, Opening


class _State(NamedTuple):
    """The occupied spots, the robot's place, and the number of others in each part."""

    spots: tuple[int, ...]
    here: int
    counts: Counts


class TooMuchWork(Exception):
    """The relaxed problem is too large."""


@dataclass
class Work:
    """The number of states that may still be visited."""

    left: int


class Relaxation:
    """Distances of one robot to a place, by the positions of the robot and the others.

    Args:
        layer: Returns the lanes while some spots are occupied.
        target: The place.
        spots: The spots that are occupied at first.
        waypoints: The number of others that are at waypoints at first.
        work: The number of states that may still be visited, which decreases.
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
        """Return the minimum number of moves with the robot at a place; infinite if it can't reach the target.

        They are its moves and one move of each robot that leaves a spot. The second number is the approximate number of
        moves that the others need before the next one of these.

        Raises:
            TooMuchWork: The limit of states is reached.
        """
        spots = tuple(spot for spot in self._spots if spot in others)
        layer = self._layers[spots]
        state = _State(spots, here, layer.counts(here, others))
        if sum(state.counts) + len(spots) != self._many:
            # Two robots share the place, or touch from the start.
            return 0.0, 0.0
        left = self._distance(state)
        if left in (0.0, math.inf):
            return left, 0.0
        wanted: dict[int, list[Counts]] = {}
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
        """Return the approximate number of moves of others before a robot can leave its spot."""
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

    def _arranging(self, layer: Layer, here: int, end: int, options: Sequence[Counts], others: Sequence[int]) -> float:
        """Return the approximate number of others' moves to reach numbers in each part after the robot's next move."""
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
        """Return the distance of a state, by breadth-first search back from the target, as far as needed."""
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

    def _before_leaving(self, spot: int, after: Layer, before: Layer, here: int, counts: Counts) -> Iterator[Counts]:
        """Yield the possible numbers of others in each part before one left a spot."""
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

    def _before_opening(self, opening: Opening, sizes: Sequence[int], counts: Counts) -> Iterator[Counts]:
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
"""The number of moves assumed if there is no route."""


def _effort(wanted: Counts, there: Sequence[Sequence[float]], holes: Sequence[Sequence[float]]) -> float:
    """Return the number of moves to reach these numbers in each part, by the distances to the place between."""
    effort = 0.0
    for many, robots, free in zip(wanted, there, holes, strict=True):
        change = many - len(robots)
        row = robots[:-change] if change < 0 else free[:change]
        effort += sum(min(away, _LONG) for away in row) + _LONG * (abs(change) - len(row))
    return effort


@lru_cache(maxsize=100_000)
def _split(total: int, sizes: Counts) -> tuple[Counts, ...]:
    """Return all distributions of this number of robots over parts of these sizes."""
    if not sizes:
        return () if total else ((),)
    least, most = max(0, total - sum(sizes[1:])), min(total, sizes[0])
    return tuple((first, *rest) for first in range(least, most + 1) for rest in _split(total - first, sizes[1:]))
