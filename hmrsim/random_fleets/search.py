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
"""The weight of the remaining moves relative to the moves made: higher finds a plan sooner, but a longer one."""

_LEAP = 100
"""The weight of a move of the relaxed problem relative to moves of others, of which fewer precede each such move."""

_COMPLETE_EVERY = 4
"""The interval of complete expansions; the others omit moves of robots that are not in the way."""

_MAX_HOLES = 8
"""Maximum free places to try for a robot in the way."""


class Step(NamedTuple):
    """A robot's part of a step: start, end and class, which is -1 for the robot of the search."""

    start: int
    end: int
    kind: int


class Distances:
    """The numbers of moves to a place from all places, by class, without robots in the way."""

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
        target: The place. Only this place may be off the waypoints: other robots only leave such places.

    Attributes:
        expanded: The number of expanded configurations.
    """

    def __init__(self, lanes: Lanes, kind: int, target: int, max_states: int) -> None:
        self._lanes = lanes
        self._kind = kind
        self._target = target
        self._max_states = max_states
        self._away = Distances(lanes, target).all(kind)
        self._predecessors: dict[State, tuple[State, list[list[Step]]] | None] = {}
        self._cost: dict[State, int] = {}
        # Heaps of the configurations to expand, promising steps first and all others later.
        self._promising: list[tuple[float, int, State]] = []
        self._complete: list[tuple[float, int, State]] = []
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
        relaxation = self._lanes.relaxation(self._kind, self._target, start)
        self._predecessors[start], self._cost[start] = None, 0
        self._push(start, relaxation)
        while self._promising or self._complete:
            if self.expanded >= self._max_states:
                return None
            self.expanded += 1
            complete = not self._promising or (self._complete and self.expanded % _COMPLETE_EVERY == 0)
            rank, _, state = heapq.heappop(self._complete if complete else self._promising)
            self._count_robots(state)
            for after, steps in self._complete_steps(state) if complete else self._promising_steps(state):
                if after in self._predecessors:
                    continue
                self._predecessors[after] = state, steps
                self._cost[after] = self._cost[state] + sum(map(len, steps))
                if after[0] == self._target:
                    return self._plan(after)
                self._push(after, relaxation)
            if not complete:
                self._number += 1
                heapq.heappush(self._complete, (rank, self._number, state))
        return False

    def _push(self, state: State, relaxation: Relaxation) -> None:
        """Push a configuration, unless the target can't be reached from it."""
        count = self._lanes.count
        moves, others_moves = relaxation.moves(state[0], [code // count for code in state[1]])
        if moves == math.inf:
            return
        self._number += 1
        rank = self._cost[state] + _WEIGHT * (_LEAP * moves + others_moves)
        heapq.heappush(self._promising, (rank, self._number, state))

    def _plan(self, state: State) -> list[list[Step]]:
        """Return the steps from the start to a configuration."""
        steps: list[list[Step]] = []
        predecessor = self._predecessors[state]
        while predecessor is not None:
            state, more = predecessor
            steps = [*more, *steps]
            predecessor = self._predecessors[state]
        return steps

    def _count_robots(self, state: State) -> None:
        """Count the robots at each place, and mark their classes."""
        count = self._lanes.count
        counts, masks = [0] * len(self._lanes.room), [0] * len(self._lanes.room)
        counts[state[0]], masks[state[0]] = 1, 1 << self._kind
        for code in state[1]:
            place, kind = divmod(code, count)
            counts[place] += 1
            masks[place] |= 1 << kind
        self._counts, self._masks = counts, masks

    def _promising_steps(self, state: State) -> Iterator[tuple[State, list[list[Step]]]]:
        """Yield the robot's steps, and chains of moves by which robots in its way move to free places."""
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
        for i, code in enumerate(others):
            # Robots of one class at one place are interchangeable.
            if i and code == others[i - 1]:
                continue
            place, kind = divmod(code, lanes.count)
            for end, blocks in lanes.moves[kind][place]:
                if lanes.is_waypoint[end] and self._is_open(end, blocks):
                    after = sorted((*others[:i], end * lanes.count + kind, *others[i + 1 :]))
                    yield (here, tuple(after)), [[Step(place, end, kind)]]

    def _is_open(self, end: int, blocks: Sequence[tuple[int, int]]) -> bool:
        """Return whether there is room at the end of a move, and no robot blocks it."""
        return self._counts[end] < self._lanes.room[end] and not any(self._masks[at] & kinds for at, kinds in blocks)

    def _chains(self, state: State, blocker: int, cleared: int) -> Iterator[tuple[State, list[list[Step]]]]:
        """Yield chains of moves in which the robot at a place moves to a free waypoint, after those in its way.

        The waypoint *cleared* stays free.
        """
        lanes, here = self._lanes, state[0]
        if blocker == here:
            return
        kind = self._kind_at(blocker)
        predecessors: dict[int, int] = {blocker: -1, here: -1}
        todo, holes = deque([blocker]), 0
        while todo and holes < _MAX_HOLES:
            place = todo.popleft()
            for end, _ in lanes.moves[kind][place]:
                if end in predecessors or not lanes.is_waypoint[end]:
                    continue
                predecessors[end] = place
                todo.append(end)
                if self._counts[end] < lanes.room[end] and end != cleared:
                    holes += 1
                    yield from self._shift(state, predecessors, end)

    def _kind_at(self, place: int) -> int:
        """Return the lowest class of the robots at a place."""
        mask = self._masks[place]
        return (mask & -mask).bit_length() - 1

    def _shift(
        self, state: State, predecessors: Mapping[int, int], hole: int
    ) -> Iterator[tuple[State, list[list[Step]]]]:
        """Yield the configuration after all robots on the path to a hole have moved up, if that is possible."""
        path = [hole]
        while predecessors[path[-1]] >= 0:
            path.append(predecessors[path[-1]])
        codes, steps, to = [*state[1]], list[list[Step]](), 0
        for i in range(1, len(path)):
            code = self._code_at(path[i], codes)
            if code is None:
                continue
            # It drives lane by lane to the place that the robot ahead has left.
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
        """Return whether a robot of a class can move while the others are at the places of *codes*."""
        lanes = self._lanes
        blocks = next((blocks for to, blocks in lanes.moves[kind][start] if to == end), None)
        if blocks is None or sum(code // lanes.count == end for code in codes) + (here == end) >= lanes.room[end]:
            return False
        around = dict(blocks)
        if around.get(here, 0) >> self._kind & 1:
            return False
        return not any(around.get(code // lanes.count, 0) >> code % lanes.count & 1 for code in codes)

    def _ring_steps(self, state: State) -> Iterator[tuple[State, list[list[Step]]]]:
        """Yield the configurations after all robots of a full ring have moved at once."""
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
