"""Resolution of deadlocks: a search over the vehicles' places finds moves, which they make one by one."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import chain
from typing import TYPE_CHECKING

from hmrsim.traffic.policies._nearness import touch
from hmrsim.traffic.policies._resolution import Move, Step
from hmrsim.traffic.policies.reserve import rank

if TYPE_CHECKING:
    from hmrsim.navigation.lanes import Edge
    from hmrsim.traffic.policies._admission import AdmissionControl
    from hmrsim.traffic.policies._reservations import Slots
    from hmrsim.traffic.policies._resolution import Reservations
    from hmrsim.traffic.policies._vehicle import Vehicle

_MAX_ROBOTS = 6
"""Vehicles that are moved for one: each more makes the search longer by as many times as there are waypoints."""

_PAIR = 2

_Places = tuple[int, ...]
_Way = tuple[int, "Edge"]
"""A vehicle, by its number in the group, and the lane that it drives."""
_Ways = tuple[_Way, ...]
_Before = dict[_Places, tuple[_Places, _Ways] | None]


class DeadlockResolver:
    """Searches for moves that let a vehicle go on.

    Args:
        slots: The places of the vehicles.
        reservations: What other resolutions need.
        movable: Returns whether the first vehicle may be moved for the second.
    """

    def __init__(
        self,
        admission: AdmissionControl,
        slots: Slots,
        reservations: Reservations,
        movable: Callable[[Vehicle, Vehicle], bool],
    ) -> None:
        self._admission = admission
        self._slots = slots
        self._reservations = reservations
        self._movable = movable

    def find_steps(self, robot: Vehicle, target: int, max_states: int) -> tuple[list[Step] | None, bool]:
        """Return the fewest steps after which a vehicle is at a waypoint, None if none are found, and if that is sure.

        The vehicles in its way enter the search one after the other, the nearest first.

        *max_states* is how many combinations of places are searched in all; it is not sure if there are more.
        """
        if self._slots.held(robot)[-1] >= len(self._admission.graph.lanes.out):
            # It stands in the middle of a lane, which only the vehicles before and behind it can leave.
            return None, True
        if not all(self._may_join(other, robot) for other in self._slots.in_the_way(robot, target)):
            return None, True
        group = [robot]
        while len(group) < _MAX_ROBOTS and max_states > 0:
            joining = next(self._around(group, target), None)
            if joining is None:
                return None, True
            group.append(joining)
            steps, searched = self._search(group, target, max_states)
            if steps is not None:
                return steps, True
            max_states -= searched
        return None, max_states > 0

    def _around(self, group: Sequence[Vehicle], target: int) -> Iterator[Vehicle]:
        """Yield the vehicles that may be moved, in breadth-first order from the target."""
        out, near = self._admission.graph.lanes.out, self._slots.near
        seen, todo = {target}, deque([target])
        while todo:
            node = todo.popleft()
            for other in sorted(self._slots.inside(node), key=rank):
                if other not in group and self._may_join(other, group[0]):
                    yield other
            for edge in out[node]:
                beside = (at for slot in edge.leg.slots for at in near.get(slot, ()) if at < len(out))
                for end in (edge.end, *beside):
                    if end not in seen:
                        seen.add(end)
                        todo.append(end)

    def _may_join(self, other: Vehicle, robot: Vehicle) -> bool:
        """Return whether a vehicle stands at a waypoint, and may be moved for another one."""
        held = self._slots.held(other)
        return len(held) == 1 and held[0] < len(self._admission.graph.lanes.out) and self._movable(other, robot)

    def _search(self, group: Sequence[Vehicle], target: int, max_states: int) -> tuple[list[Step] | None, int]:
        """Search the places of a group breadth first; return the steps, and how many combinations were searched."""
        start: _Places = tuple(self._slots.held(robot)[-1] for robot in group)
        before: _Before = {start: None}
        moves = _GroupMoves(self._admission, self._slots, self._reservations, group)
        todo = deque([start])
        while todo and len(before) < max_states:
            places = todo.popleft()
            if places[0] == target:
                return _steps(before, places, group), len(before)
            for ways in moves.steps(places):
                after = [*places]
                for i, edge in ways:
                    after[i] = edge.end
                there = tuple(after)
                if there not in before:
                    before[there] = (places, ways)
                    todo.append(there)
        return None, len(before)


class _GroupMoves:
    """Which vehicles of a group can move from where they are, one alone or a circle of them at once."""

    def __init__(
        self, admission: AdmissionControl, slots: Slots, reservations: Reservations, group: Sequence[Vehicle]
    ) -> None:
        self._admission = admission
        self._slots = slots
        self._reservations = reservations
        self._group = group
        self._ways: dict[tuple[int, int], list[tuple[Edge, dict[int, float]]]] = {}
        self._rooms: dict[int, float] = {}

    def steps(self, places: _Places) -> Iterator[_Ways]:
        """Yield the steps that are possible where the vehicles of the group are at these places."""
        into: list[list[_Way]] = []
        for i, place in enumerate(places):
            blocked: list[_Way] = []
            for edge, beside in self._ways_from(i, place):
                if beside and self._touches(i, beside, places):
                    continue
                if places.count(edge.end) < self._room(edge.end):
                    yield ((i, edge),)
                else:
                    blocked.append((i, edge))
            into.append(blocked)
        if len(places) > _PAIR:
            for way in chain.from_iterable(into):
                yield from self._circles(places, into, (way,))

    def _circles(self, places: _Places, into: Sequence[Sequence[_Way]], ways: _Ways) -> Iterator[_Ways]:
        """Yield the circles of three or more that begin with some ways: each moves to where the next one is.

        Two can't change places on the one lane between them.
        """
        first, end = ways[0][0], ways[-1][1].end
        if end == places[first]:
            if len(ways) > _PAIR:
                yield ways
            return
        for j in range(first + 1, len(places)):
            if places[j] == end and all(j != i for i, _ in ways):
                for way in into[j]:
                    yield from self._circles(places, into, (*ways, way))

    def _ways_from(self, i: int, place: int) -> list[tuple[Edge, dict[int, float]]]:
        """Return the lanes from a waypoint on which only the group can be in the way of one of it.

        With each go the waypoints near it, and how far away they are.
        """
        known = self._ways.get((i, place))
        if known is None:
            found = self._find_ways(self._group[i], place)
            known = self._ways[i, place] = [(edge, self._beside(edge)) for edge in found]
        return known

    def _beside(self, edge: Edge) -> dict[int, float]:
        waypoints, beside = len(self._admission.graph.lanes.out), dict[int, float]()
        for slot in edge.leg.slots:
            for at, away in self._slots.near.get(slot, {}).items():
                if at < waypoints:
                    beside[at] = min(away, beside.get(at, away))
        return beside

    def _find_ways(self, robot: Vehicle, place: int) -> Iterator[Edge]:
        for edge in self._admission.graph.lanes.out[place]:
            lane, slots = edge.leg.lane, edge.leg.slots
            if lane is None or not self._admission.may_drive(robot, lane):
                continue
            others = (other for slot in slots for other in self._slots.in_the_way(robot, slot))
            if all(other in self._group for other in others) and not self._reservations.against(
                robot, slots, self._group[0]
            ):
                yield edge

    def _room(self, slot: int) -> float:
        """Return how many of the group there is room for at a waypoint."""
        room = self._rooms.get(slot)
        if room is None:
            room = self._rooms[slot] = self._slots.room(slot, self._group)
        return room

    def _touches(self, i: int, beside: Mapping[int, float], places: _Places) -> bool:
        """Return whether one of a group would touch another one of it on a lane with these waypoints beside it."""
        group = self._group
        return any(
            at in beside and j != i and touch(beside[at], group[i].radius + group[j].radius)
            for j, at in enumerate(places)
        )


def _steps(before: _Before, places: _Places, group: Sequence[Vehicle]) -> list[Step]:
    steps: list[Step] = []
    while (step := before[places]) is not None:
        places, ways = step
        steps.append([Move(group[i], edge) for i, edge in ways])
    return steps[::-1]
