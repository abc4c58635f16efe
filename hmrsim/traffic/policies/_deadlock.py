"""The resolution of deadlocks: a search for moves of other vehicles that let a blocked vehicle reach its next place.

The state of a search is the combination of places at which the vehicles stand. Vehicles of the same size that may drive
the same lanes are interchangeable, so that combinations that differ only in their order are the same.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
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
"""The maximum number of vehicles in an exhaustive search: each further one multiplies its duration."""

_MAX_CLEARING = 24
"""The maximum number of vehicles to move, one after the other, to clear a route."""

_MAX_AROUND = 80
"""The maximum number of places to examine, nearest first, for vehicles that may have to move."""

_MAX_FOR_REMEDY = 4_000
"""Maximum combinations of places to visit for a remedy in a message."""

_FEW_STEPS = 4
"""The maximum number of steps of a solution that is accepted without a search for a shorter one."""

_PAIR = 2
"""The number of vehicles that can't swap places, as they would meet on the lane between them."""

_Drive = tuple[int, "Way"]
"""A vehicle, by its number in the group, and the way that it takes."""
_Drives = tuple[_Drive, ...]
_Predecessors = dict[object, tuple["Places", object, _Drives]]
"""For the key of each reached combination: the places, the key of its predecessor, and the drives from there."""


class Movable(Protocol):
    """A function that decides whether a vehicle may be moved out of the way of another."""

    def __call__(self, other: Vehicle, robot: Vehicle, *, soon: bool) -> bool:
        """Return whether *other* may be moved for *robot* now or, if *soon*, once it has stopped or ended its work."""


class DeadlockResolver:
    """Searches for moves that let a vehicle continue.

    Args:
        slots: Know the places of the vehicles.
        ways: Find the ways from these places.
        resolutions: The resolutions in progress, which need slots.
        movable: Returns whether a vehicle may be moved for another.
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
        """Return steps that bring a vehicle to a slot, or None, and whether that result is final.

        First, an exhaustive search finds the fewest steps. It considers the vehicles in the way, and adds one at a
        time, the nearest first. If it finds no steps, or many, a *patient* search makes two more attempts: it includes
        the vehicles that will soon be movable, and it clears a route for the vehicle, which may make room itself first.
        The steps with the shortest total length win.

        Each exhaustive search visits at most *max_states* combinations of places; if that limit ends it, the result is
        not final. Without *patient*, the result is final only if there are steps.
        """
        nearest = list(islice(self._movable_around(robot, target, soon=False), _MAX_SEARCHED))
        steps, final = self._search_nearest(robot, nearest, target, max_states)
        if not patient or (steps is not None and len(steps) <= _FEW_STEPS):
            return steps, steps is not None
        around = list(islice(self._movable_around(robot, target, soon=True), _MAX_CLEARING - 1))
        others = around[:_MAX_SEARCHED]
        solutions = [steps, None if final and others == nearest else self._clear_route(robot, around, target)]
        if others != nearest:
            more, final = self._search_nearest(robot, others, target, max_states)
            solutions.append(more)
        return min(filter(None, solutions), key=_length, default=None), final

    def _search_nearest(
        self, robot: Vehicle, nearest: Sequence[Vehicle], target: int, max_states: int
    ) -> tuple[list[Step] | None, bool]:
        """Search with more and more of the nearest vehicles; return the steps, or None and whether that is final.

        No steps are a final result if all vehicles took part. A vehicle that blocks none of the group's ways is added
        to the group, but a search with it would find nothing new.
        """
        group = self._group(robot, target)
        for number, other in enumerate(nearest[: _MAX_SEARCHED - 1]):
            group.add(other)
            if number and not group.gains_ways_from(other):
                continue
            steps, searched = _search(group, max_states)
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
        places = [*group.start]
        steps: list[Step] = []
        for i, way in drives:
            steps.append([Move(group.robots[i], way, places[i])])
            places[i] = way.end
        return steps

    def _movable_around(self, robot: Vehicle, target: int, *, soon: bool) -> Iterator[Vehicle]:
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
        """Return the neighbors of a place: along the lanes, on occupied lanes, and beside the lanes."""
        slots, near = self._slots, self._slots.near
        ends, around = self._around_place(place)
        places = [*ends]
        for slot in around:
            if slot != place and slots.holders[slot] and slots.is_lane(slot):
                places.append(slot)
            if slot in near:
                places += [other for other in near[slot] if not slots.is_lane(other) or slots.holders[other]]
        return places

    def _around_place(self, place: int) -> tuple[Sequence[int], Sequence[int]]:
        """Return the places at the ends of the lanes from a place, and the slots of the place and these lanes."""
        slots, lanes = self._slots, self._admission.graph.lanes
        if place in slots.points:
            ways = self._ways.from_spot(place)
            return [way.end for way in ways], [slot for way in ways for slot in way.slots]
        if slots.is_lane(place):
            return [edge.end for edge in lanes.leading_to(place)], [place]
        cached = self._around_waypoint.get(place)
        if cached is None:
            edges = lanes.out[place]
            cached = [edge.end for edge in edges], [place, *(edge.leg.slots[0] for edge in edges)]
            self._around_waypoint[place] = cached
        return cached


def find_pass(
    admission: Admission, slots: Slots, ways: Ways, robots: Sequence[Vehicle], target: int
) -> list[Step] | None:
    """Return steps of some vehicles that bring the first to a slot, while all others stay; None if none are found."""
    group = Group(admission, slots, ways, None, robots[0], target)
    for robot in robots[1:_MAX_SEARCHED]:
        group.add(robot)
    return _search(group, _MAX_FOR_REMEDY)[0]


def _search(group: Group, max_states: int) -> tuple[list[Step] | None, int]:
    """Search the places of a group breadth-first; return the steps, and the number of combinations reached."""
    start = group.start
    first = group.key(start)
    reached: _Predecessors = {first: (start, None, ())}
    todo = deque([first])
    while todo and len(reached) < max_states:
        key = todo.popleft()
        places = reached[key][0]
        for drives in _moves(group, places):
            moved = [*places]
            for i, way in drives:
                moved[i] = way.end
            after = tuple(moved)
            key_after = group.key(after)
            if key_after in reached:
                continue
            reached[key_after] = (after, key, drives)
            if after[0] == group.target:
                return _steps(reached, key_after, group), len(reached)
            todo.append(key_after)
    return None, len(reached)


def _length(steps: Sequence[Step]) -> float:
    return sum(move.way.length for step in steps for move in step)


def _moves(group: Group, places: Places) -> Iterator[_Drives]:
    """Yield the possible drives from some places: of a single vehicle, or of three or more in a circle at once."""
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
    if sum(map(bool, into)) > _PAIR:
        for drive in chain.from_iterable(into):
            yield from filter(group.fit, _circles(places, into, (drive,)))


def _circles(places: Places, into: Sequence[Sequence[_Drive]], drives: _Drives) -> Iterator[_Drives]:
    """Yield the circles that begin with some drives, in which each vehicle takes the place of the next one."""
    first, end = drives[0][0], drives[-1][1].end
    if end == places[first]:
        if len(drives) > _PAIR:
            yield drives
        return
    for j in range(first + 1, len(places)):
        if places[j] == end and j not in [i for i, _ in drives]:
            for drive in into[j]:
                yield from _circles(places, into, (*drives, drive))


def _steps(reached: _Predecessors, key: object, group: Group) -> list[Step]:
    """Return the steps from the start to a reached combination of places."""
    steps: list[Step] = []
    while True:
        _, earlier, drives = reached[key]
        if earlier is None:
            return steps[::-1]
        places = reached[earlier][0]
        steps.append([Move(group.robots[i], way, places[i]) for i, way in drives])
        key = earlier
