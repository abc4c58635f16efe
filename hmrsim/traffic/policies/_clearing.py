"""The clearing of a route: the vehicles on it move aside one after the other, and push others away.

A search of all combinations of places is exact, but takes too long for many vehicles. Here only vehicles that are in
the way move. The blocked vehicle first tries to clear the route from its own place. If that is impossible because the
others have to get past it, it moves out of their way first: to each place that it can reach, the nearest first.
"""

from __future__ import annotations

import heapq
import math
from collections import deque
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hmrsim.traffic.policies._group import Group, Places
    from hmrsim.traffic.policies._ways import Way

    Drives = tuple[tuple[int, Way], ...]
    """Drives in order, each with the number of the vehicle in the group and its way."""

_MOST_PLACES = 120
"""The maximum number of combinations of places from which the search tries to clear the route."""

_MOST_TRIES = 4_000
"""The maximum number of attempts to move a vehicle aside, in the whole search."""

_MOST_REFUGES = 6
"""The maximum number of places that are tried for one vehicle that has to move aside."""

_OCCUPIED = 3
"""The additional cost of an occupied place, in ways, since the vehicle there would have to move in turn."""

_BESIDE = 2
"""The additional cost of a place beside the lanes, in ways, since orders may need it."""


def length_of(drives: Drives) -> float:
    """Return the total length of drives, in the world's unit."""
    return sum(way.length for _, way in drives)


class Clearing:
    """A search for moves that clear the route of the first vehicle of a group."""

    def __init__(self, group: Group) -> None:
        self._group = group
        self._tries = 0

    def find(self) -> Drives | None:
        """Return the drives, in order, that bring the first vehicle to its target; None if none are found."""
        group = self._group
        heap: list[tuple[float, int, Places, Drives]] = [(0.0, 0, group.start, ())]
        seen, number = {group.key(group.start)}, 0
        best: Drives | None = None
        least = math.inf
        for _ in range(_MOST_PLACES):
            if not heap or heap[0][0] >= least or self._tries > _MOST_TRIES:
                break
            _, _, places, drives = heapq.heappop(heap)
            route = self._route(places)
            if route is not None:
                cleared = self._clear(places, [(0, way) for way in route])
                if cleared is not None:
                    moves = (*drives, *cleared[1], *((0, way) for way in route))
                    if (length := length_of(moves)) < least:
                        best, least = moves, length
            for way in group.ways(0, places):
                aside = self._clear(places, [(0, way)])
                if aside is None:
                    continue
                after = (way.end, *aside[0][1:])
                if (key := group.key(after)) not in seen:
                    seen.add(key)
                    number += 1
                    moves = (*drives, *aside[1], (0, way))
                    heapq.heappush(heap, (length_of(moves), number, after, moves))
        return best

    def _route(self, places: Places) -> list[Way] | None:
        """Return the ways by which the first vehicle reaches its target, ignoring the rest of the group."""
        group = self._group
        predecessors: dict[int, tuple[int, Way] | None] = {places[0]: None}
        todo = deque([places[0]])
        while todo and group.target not in predecessors:
            place = todo.popleft()
            for way in group.ways(0, (place, *places[1:])):
                if way.end not in predecessors:
                    predecessors[way.end] = place, way
                    todo.append(way.end)
        if group.target not in predecessors:
            return None
        route: list[Way] = []
        at = group.target
        while (step := predecessors[at]) is not None:
            at, way = step
            route.append(way)
        return route[::-1]

    def _clear(self, places: Places, wanted: Sequence[tuple[int, Way]]) -> tuple[Places, Drives] | None:
        """Return the places after other vehicles have moved out of the first one's way, and their moves."""
        moves: Drives = ()
        for _ in range(2 * len(places)):
            blocker = self._blocker(places, wanted)
            if blocker is None:
                return places, moves
            moved = self._move_aside(places, blocker, wanted, {0})
            if moved is None:
                return None
            places, moves = moved[0], (*moves, *moved[1])
        return None

    def _blocker(self, places: Places, wanted: Sequence[tuple[int, Way]]) -> int | None:
        """Return the first vehicle that blocks the drives of the vehicle to clear; None if there is none."""
        at = places
        for _, way in wanted:
            others = self._group.in_the_way(0, way, at)
            if others:
                return others[0]
            at = (way.end, *at[1:])
        return None

    def _move_aside(
        self, places: Places, j: int, wanted: Sequence[tuple[int, Way]], stay: set[int]
    ) -> tuple[Places, Drives] | None:
        """Return the places after a vehicle has moved to where it blocks no other, and all moves for that."""
        for tried, path in enumerate(self._refuges(places, j, wanted, stay)):
            self._tries += 1
            if tried >= _MOST_REFUGES or self._tries > _MOST_TRIES:
                return None
            at = places
            moves: Drives = ()
            for number, way in enumerate(path):
                ahead = [*((j, step) for step in path[number:]), *wanted]
                cleared = self._clear_step(at, j, way, ahead, stay | {j})
                if cleared is None:
                    break
                at, moves_of_others = cleared
                moves = (*moves, *moves_of_others, (j, way))
                at = (*at[:j], way.end, *at[j + 1 :])
            else:
                return at, moves
        return None

    def _clear_step(
        self, places: Places, j: int, way: Way, wanted: Sequence[tuple[int, Way]], stay: set[int]
    ) -> tuple[Places, Drives] | None:
        """Return the places after others have moved so that a vehicle can drive a way, and their moves."""
        moves: Drives = ()
        for _ in range(len(places)):
            others = self._group.in_the_way(j, way, places)
            if not others:
                return places, moves
            if others[0] in stay or self._tries > _MOST_TRIES:
                return None
            moved = self._move_aside(places, others[0], wanted, stay)
            if moved is None:
                return None
            places, moves = moved[0], (*moves, *moved[1])
        return None

    def _refuges(
        self, places: Places, j: int, wanted: Sequence[tuple[int, Way]], stay: set[int]
    ) -> Iterator[list[Way]]:
        """Yield the routes of a vehicle to places where it blocks no other, the cheapest first."""
        group, number = self._group, 0
        heap: list[tuple[int, int, int, list[Way]]] = [(0, 0, places[j], [])]
        done: set[int] = set()
        while heap:
            cost, _, place, path = heapq.heappop(heap)
            if place in done:
                continue
            done.add(place)
            if path and not any(group.blocks(j, place, i, way) for i, way in wanted if i != j):
                yield path
            at = (*places[:j], place, *places[j + 1 :])
            for way in group.ways(j, at):
                if way.end in done:
                    continue
                others = group.in_the_way(j, way, at)
                if any(other in stay for other in others):
                    continue
                number += 1
                total = cost + 1 + _OCCUPIED * len(others) + _BESIDE * group.is_spot(way.end)
                heapq.heappush(heap, (total, number, way.end, [*path, way]))
