"""A best-first search over configurations for the steps that bring one robot to a place."""

from __future__ import annotations

import heapq
import math
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Literal, NamedTuple

if TYPE_CHECKING:
    from hmrsim.random_fleets.lanes import Lanes, State
    from hmrsim.random_fleets.relaxation import Relaxation

_WEIGHT = 3
"""The weight of the remaining moves against the moves made, so that a plan is found soon, if not the shortest one."""

_LEAP = 100
"""The number of others' moves that count as one move of the relaxed problem: more than ever precede one."""

_SHARE = 4
"""Every so many expansions is complete; the others omit the moves of robots that are in no one's way."""

_MAX_HOLES = 8
"""Maximum free places into which a robot in the way is pushed."""


class Step(NamedTuple):
    """A robot's part of a step: start, end and class."""

    start: int
    end: int
    kind: int


class Distances:
    """The number of moves to a place from everywhere, by class, without robots in the way."""

    def __init__(self, lanes: Lanes, target: int) -> None:
        self._lanes = lanes
        self._target = target
        self._known: dict[int, list[float]] = {}

    def of(self, kind: int, place: int) -> float:
        """Return the distance for a class from a place; infinite if there is no route."""
        return self.all(kind)[place]

    def all(self, kind: int) -> list[float]:
        """Return the distances for a class from all places."""
        if kind not in self._known:
            lanes, target = self._lanes, self._target
            into: list[list[int]] = [[] for _ in lanes.room]
            for start, out in enumerate(lanes.moves[kind]):
                for end, _ in out:
                    if lanes.is_waypoint[end] or end == target:
                        into[end].append(start)
            away = [math.inf] * len(into)
            away[target], todo = 0.0, deque([target])
            while todo:
                place = todo.popleft()
                for before in into[place]:
                    if away[before] == math.inf:
                        away[before] = away[place] + 1
                        todo.append(before)
            self._known[kind] = away
        return self._known[kind]


class Search:
    """A best-first search for the steps that bring one robot to a place.

    Args:
        kind: The robot's class.
        target: The place. It alone may be off the waypoints: other robots leave such places, and do not come back.
    """

    def __init__(self, lanes: Lanes, kind: int, target: int, max_states: int) -> None:
        self._lanes = lanes
        self._kind = kind
        self._target = target
        self._max_states = max_states
        self._away = Distances(lanes, target).all(kind)
        self._relaxation: Relaxation | None = None
        self._before: dict[State, tuple[State, list[list[Step]]] | None] = {}
        self._cost: dict[State, int] = {}
        self._first: list[tuple[float, int, State]] = []
        self._rest: list[tuple[float, int, State]] = []
        self._number = 0
        self.expanded = 0
        self._counts: list[int] = []
        self._masks: list[int] = []

    def run(self, start: State) -> list[list[Step]] | Literal[False] | None:
        """Return the steps, False if there are none, or None if too many configurations were expanded.

        Raises:
            TooMuchWork: The relaxed problem is too large.
        """
        if self._away[start[0]] == math.inf:
            return False
        if start[0] == self._target:
            return []
        self._relaxation = self._lanes.relaxation(self._kind, self._target, start)
        self._before[start], self._cost[start] = None, 0
        self._push(start)
        while self._first or self._rest:
            if self.expanded >= self._max_states:
                return None
            self.expanded += 1
            complete = not self._first or (self._rest and self.expanded % _SHARE == 0)
            rank, _, state = heapq.heappop(self._rest if complete else self._first)
            self._look(state)
            found = self._complete_steps(state) if complete else self._promising_steps(state)
            for after, steps in found:
                if after in self._before:
                    continue
                self._before[after] = state, steps
                self._cost[after] = self._cost[state] + sum(map(len, steps))
                if after[0] == self._target:
                    return self._plan(after)
                self._push(after)
            if not complete:
                self._number += 1
                heapq.heappush(self._rest, (rank, self._number, state))
        return False

    def _push(self, state: State) -> None:
        count = self._lanes.count
        if self._relaxation is None:
            raise AssertionError
        left, effort = self._relaxation.moves(state[0], [code // count for code in state[1]])
        if left == math.inf:
            return
        self._number += 1
        heapq.heappush(self._first, (self._cost[state] + _WEIGHT * (_LEAP * left + effort), self._number, state))

    def _plan(self, state: State) -> list[list[Step]]:
        steps: list[list[Step]] = []
        before = self._before[state]
        while before is not None:
            state, more = before
            steps = [*more, *steps]
            before = self._before[state]
        return steps

    def _look(self, state: State) -> None:
        """Count the robots at each place."""
        count = self._lanes.count
        counts, masks = [0] * len(self._lanes.room), [0] * len(self._lanes.room)
        counts[state[0]], masks[state[0]] = 1, 1 << self._kind
        for code in state[1]:
            place, kind = divmod(code, count)
            counts[place] += 1
            masks[place] |= 1 << kind
        self._counts, self._masks = counts, masks

    def _promising_steps(self, state: State) -> Iterator[tuple[State, list[list[Step]]]]:
        """Yield the robot's steps, and chains of moves by which those in its way make room in free places."""
        lanes, (here, others) = self._lanes, state
        for end, blocks in lanes.moves[self._kind][here]:
            if not (lanes.is_waypoint[end] or end == self._target):
                continue
            blockers = [number for number, kinds in blocks if self._masks[number] & kinds]
            if self._counts[end] >= lanes.room[end]:
                blockers.append(end)
            if not blockers:
                yield (end, others), [[Step(here, end, -1)]]
            elif self._away[end] < math.inf:
                for blocker in blockers:
                    yield from self._chains(state, blocker, end)
        yield from self._ring_steps(state)

    def _complete_steps(self, state: State) -> Iterator[tuple[State, list[list[Step]]]]:
        """Yield the moves of all other robots to waypoints."""
        lanes, (here, others) = self._lanes, state
        before = -1
        for i, code in enumerate(others):
            if code == before:
                continue
            before = code
            place, kind = divmod(code, lanes.count)
            for end, blocks in lanes.moves[kind][place]:
                if lanes.is_waypoint[end] and self._is_open(end, blocks, self._counts, self._masks):
                    after = sorted((*others[:i], end * lanes.count + kind, *others[i + 1 :]))
                    yield (here, tuple(after)), [[Step(place, end, kind)]]

    def _is_open(
        self, end: int, blocks: Sequence[tuple[int, int]], counts: Sequence[int], masks: Sequence[int]
    ) -> bool:
        return counts[end] < self._lanes.room[end] and not any(masks[number] & kinds for number, kinds in blocks)

    def _chains(self, state: State, blocker: int, wanted: int) -> Iterator[tuple[State, list[list[Step]]]]:
        """Yield the steps in which the robot at a place moves along waypoints to free ones, after those in its way."""
        lanes, here = self._lanes, state[0]
        if blocker == here:
            return
        kind = self._kind_at(blocker)
        came: dict[int, int] = {blocker: -1, here: -1}
        todo, holes = deque([blocker]), 0
        while todo and holes < _MAX_HOLES:
            place = todo.popleft()
            for end, _ in lanes.moves[kind][place]:
                if end in came or not lanes.is_waypoint[end]:
                    continue
                came[end] = place
                todo.append(end)
                if self._counts[end] < lanes.room[end] and end != wanted:
                    holes += 1
                    yield from self._shift(state, came, end)

    def _kind_at(self, place: int) -> int:
        """Return the class of a robot at a place."""
        mask = self._masks[place]
        return (mask & -mask).bit_length() - 1

    def _shift(self, state: State, came: Mapping[int, int], hole: int) -> Iterator[tuple[State, list[list[Step]]]]:
        """Yield the configuration after a chain of moves, if all of them are possible."""
        path = [hole]
        while came[path[-1]] >= 0:
            path.append(came[path[-1]])
        codes, steps, to = [*state[1]], list[list[Step]](), 0
        for i in range(1, len(path)):
            code = self._code_at(path[i], codes)
            if code is None:
                continue
            # It drives from lane to lane to where the one before it was.
            for j in range(i, to, -1):
                kind = code % self._lanes.count
                if not self._can_move(state[0], codes, kind, path[j], path[j - 1]):
                    return
                codes.remove(code)
                code = path[j - 1] * self._lanes.count + kind
                codes.append(code)
                steps.append([Step(path[j], path[j - 1], kind)])
            to = i
        yield (state[0], tuple(sorted(codes))), steps

    def _code_at(self, place: int, codes: Sequence[int]) -> int | None:
        return next((code for code in codes if code // self._lanes.count == place), None)

    def _can_move(self, here: int, codes: Sequence[int], kind: int, start: int, end: int) -> bool:
        """Return whether a robot of a class can move while the others are at these places."""
        lanes = self._lanes
        blocks = next((blocks for to, blocks in lanes.moves[kind][start] if to == end), None)
        if blocks is None or sum(code // lanes.count == end for code in codes) + (here == end) >= lanes.room[end]:
            return False
        around = dict(blocks)
        if around.get(here, 0) >> self._kind & 1:
            return False
        return not any(around.get(code // lanes.count, 0) >> code % lanes.count & 1 for code in codes)

    def _ring_steps(self, state: State) -> Iterator[tuple[State, list[list[Step]]]]:
        """Yield the configurations after all robots of a full ring move at once."""
        lanes, (here, others) = self._lanes, state
        for ring in lanes.rings:
            if any(self._counts[place] < lanes.room[place] for place in ring):
                continue
            steps, codes, place = [], [*others], here
            for start, end in zip(ring, (*ring[1:], ring[0]), strict=True):
                if start == here:
                    kind, place = self._kind, end
                    steps.append(Step(start, end, -1))
                else:
                    kind = self._kind_at(start)
                    codes.remove(start * lanes.count + kind)
                    codes.append(end * lanes.count + kind)
                    steps.append(Step(start, end, kind))
                blocks = next((blocks for to, blocks in lanes.moves[kind][start] if to == end), None)
                if blocks is None or any(self._masks[at] & kinds for at, kinds in blocks if at not in ring):
                    break
            else:
                yield (place, tuple(sorted(codes))), [steps]
