"""Resolution of deadlocks: two searches over the places of vehicles find moves, which they make one after the other.

Vehicles that are only in the way are interchangeable: whichever of them is where makes no difference to the one that
is to go on, as long as they are of one size and may drive the same lanes. So the searches tell places apart by kind,
not by vehicle.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from itertools import chain, islice
from typing import TYPE_CHECKING, Protocol

from hmrsim.traffic.policies._clearing import Clearing
from hmrsim.traffic.policies._group import Group
from hmrsim.traffic.policies._resolution import Move, Step
from hmrsim.traffic.rules import by_rank

if TYPE_CHECKING:
    from hmrsim.traffic.admission import Admission
    from hmrsim.traffic.policies._group import Places
    from hmrsim.traffic.policies._reservations import Slots
    from hmrsim.traffic.policies._resolution import Resolutions
    from hmrsim.traffic.policies._ways import Way, Ways
    from hmrsim.traffic.rules import Vehicle

_MAX_SEARCHED = 6
"""Vehicles whose places are searched exhaustively: each more makes that longer by as many times as there are places."""

_MAX_CLEARING = 24
"""Vehicles that may be moved, one after the other, to clear a route."""

_MAX_AROUND = 80
"""Places, the nearest first, where vehicles are looked for that may have to be moved."""

_FEW_STEPS = 4
"""Steps that are taken without a look at other ones."""

_PAIR = 2

_Drive = tuple[int, "Way"]
"""A vehicle, by its number in the group, and the way that it drives."""
_Drives = tuple[_Drive, ...]
_Before = dict[object, tuple["Places", object, _Drives]]


class Movable(Protocol):
    """Predicate: the first vehicle may be moved for the second."""

    def __call__(self, other: Vehicle, robot: Vehicle, *, soon: bool) -> bool:
        """Return whether it may; if *soon*, also one that has to come to a stand or to finish its work first."""


class DeadlockResolver:
    """Searches for moves that let a vehicle go on.

    Args:
        slots: The places of the vehicles.
        ways: Where they can go.
        resolutions: The resolutions that need slots.
        movable: Whether the first vehicle may be moved for the second.
    """

    def __init__(
        self,
        admission: Admission,
        slots: Slots,
        ways: Ways,
        resolutions: Resolutions,
        movable: Movable,
    ) -> None:
        self._admission = admission
        self._slots = slots
        self._ways = ways
        self._resolutions = resolutions
        self._movable = movable
        self._around_waypoint: dict[int, tuple[Sequence[int], Sequence[int]]] = admission.graph.lanes.derived(
            DeadlockResolver, dict
        )

    def find_steps(
        self, robot: Vehicle, target: int, max_states: int, *, patient: bool
    ) -> tuple[list[Step] | None, bool]:
        """Return steps after which a vehicle is at a slot, None if none are found, and whether that is sure.

        First the places of the vehicles in its way are searched exhaustively, with one more vehicle at a time, the
        nearest first: that finds the fewest steps for these. Where there are none, or many, a *patient* search goes on:
        vehicles that are about to stand, or at work, count as well; and it is tried to clear a route for the vehicle,
        from where it is or from where it gets out of the way first. The shorter moves are taken.

        *max_states* is how many combinations of places are searched each time; it is not sure if there are more.
        """
        nearest = list(islice(self._around(robot, target, soon=False), _MAX_SEARCHED))
        steps, sure = self._search_nearest(robot, nearest, target, max_states)
        if not patient or (steps is not None and len(steps) <= _FEW_STEPS):
            return steps, steps is not None
        around = list(islice(self._around(robot, target, soon=True), _MAX_CLEARING - 1))
        others = around[:_MAX_SEARCHED]
        found = [steps, None if sure and others == nearest else self._clear_route(robot, around, target)]
        if others != nearest:
            more, sure = self._search_nearest(robot, others, target, max_states)
            found.append(more)
        return min((each for each in found if each), key=_length, default=None), sure

    def _search_nearest(
        self, robot: Vehicle, nearest: Sequence[Vehicle], target: int, max_states: int
    ) -> tuple[list[Step] | None, bool]:
        """Search the places of the nearest vehicles; it is sure that there are no steps if all take part."""
        group = self._group(robot, target)
        for other in nearest[: _MAX_SEARCHED - 1]:
            group.add(other)
            steps, searched = self._search(group, max_states)
            max_states -= searched
            if steps is not None or max_states <= 0:
                return steps, False
        return None, len(nearest) < _MAX_SEARCHED

    def _group(self, robot: Vehicle, target: int) -> Group:
        return Group(self._admission, self._slots, self._ways, self._resolutions, robot, target)

    def _clear_route(self, robot: Vehicle, others: Sequence[Vehicle], target: int) -> list[Step] | None:
        group = self._group(robot, target)
        for other in others:
            group.add(other)
        drives = Clearing(group).find()
        if drives is None:
            return None
        at = [*group.start]
        steps: list[Step] = []
        for i, way in drives:
            steps.append([Move(group.robots[i], way, at[i])])
            at[i] = way.end
        return steps

    def _around(self, robot: Vehicle, target: int, *, soon: bool) -> Iterator[Vehicle]:
        """Yield the vehicles that may be moved now, or *soon*, in breadth-first order from the target."""
        slots = self._slots
        seen, todo = {target: None}, deque([target])
        for _ in range(_MAX_AROUND):
            if not todo:
                return
            place = todo.popleft()
            inside = slots.holders[place]
            for other in sorted(inside, key=by_rank) if inside else ():
                if other is robot or slots.held(other)[-1] != place or (other.moves and slots.is_lane(place)):
                    continue
                if self._movable(other, robot, soon=soon):
                    yield other
            for slot in self._next_to(place):
                if slot not in seen:
                    seen[slot] = None
                    todo.append(slot)

    def _next_to(self, place: int) -> list[int]:
        """Return the places next to one: along the lanes, in their middle if someone stands there, and beside."""
        slots, near = self._slots, self._slots.near
        ends, around = self._around_place(place)
        found = [*ends]
        for slot in around:
            if slot != place and slots.holders[slot] and slots.is_lane(slot):
                found.append(slot)
            if slot in near:
                found += [at for at in near[slot] if not slots.is_lane(at) or slots.holders[at]]
        return found

    def _around_place(self, place: int) -> tuple[Sequence[int], Sequence[int]]:
        """Return the places to which one gets from a place along the lanes, and the slots around it, with its own."""
        slots, lanes = self._slots, self._admission.graph.lanes
        if place in slots.points:
            ways = self._ways.from_spot(place)
            return [way.end for way in ways], [slot for way in ways for slot in way.slots]
        if slots.is_lane(place):
            return [edge.end for edge in lanes.leading_to(place)], [place]
        known = self._around_waypoint.get(place)
        if known is None:
            edges = lanes.out[place]
            known = [edge.end for edge in edges], [place, *(edge.leg.slots[0] for edge in edges)]
            self._around_waypoint[place] = known
        return known

    def _search(self, group: Group, max_states: int) -> tuple[list[Step] | None, int]:
        """Search the places of a group breadth first; return the steps, and how many combinations were searched."""
        start = group.start
        first = group.key(start)
        before: _Before = {first: (start, None, ())}
        todo = deque([first])
        while todo and len(before) < max_states:
            key = todo.popleft()
            places = before[key][0]
            for drives in _moves(group, places):
                after = [*places]
                for i, way in drives:
                    after[i] = way.end
                there = tuple(after)
                reached = group.key(there)
                if reached in before:
                    continue
                before[reached] = (there, key, drives)
                if there[0] == group.target:
                    return _steps(before, reached, group), len(before)
                todo.append(reached)
        return None, len(before)


def _length(steps: Sequence[Step]) -> float:
    return sum(move.way.length for step in steps for move in step)


def _moves(group: Group, places: Places) -> Iterator[_Drives]:
    """Yield what is possible where the vehicles of a group are: one drives alone, or a circle of three or more."""
    into: list[list[_Drive]] = []
    for i in range(len(places)):
        ahead: list[_Drive] = []
        for way in group.ways(i, places):
            others = group.in_the_way(i, way, places)
            if not others:
                yield ((i, way),)
            elif {places[j] for j in others} == {way.end}:
                ahead.append((i, way))
        into.append(ahead)
    if len(places) > _PAIR:
        for drive in chain.from_iterable(into):
            yield from filter(group.fit, _circles(places, into, (drive,)))


def _circles(places: Places, into: Sequence[Sequence[_Drive]], drives: _Drives) -> Iterator[_Drives]:
    """Yield the circles of three or more that begin with some drives: each goes to where the next one is.

    Two can't change places on the one lane between them.
    """
    first, end = drives[0][0], drives[-1][1].end
    if end == places[first]:
        if len(drives) > _PAIR:
            yield drives
        return
    for j in range(first + 1, len(places)):
        if places[j] == end and j not in [i for i, _ in drives]:
            for drive in into[j]:
                yield from _circles(places, into, (*drives, drive))


def _steps(before: Mapping[object, tuple[Places, object, _Drives]], key: object, group: Group) -> list[Step]:
    steps: list[Step] = []
    while True:
        _, earlier, drives = before[key]
        if earlier is None:
            return steps[::-1]
        places = before[earlier][0]
        steps.append([Move(group.robots[i], way, places[i]) for i, way in drives])
        key = earlier
