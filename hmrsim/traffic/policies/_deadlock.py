"""Resolution of deadlocks: a search over the vehicles' places finds moves, which they make one by one."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

from hmrsim.traffic.policies.reserve import rank

if TYPE_CHECKING:
    from hmrsim.navigation.lanes import Edge
    from hmrsim.traffic.policies._admission import AdmissionControl
    from hmrsim.traffic.policies._nearness import Near
    from hmrsim.traffic.policies._reservations import Slots
    from hmrsim.traffic.policies._vehicle import Vehicle

_MAX_ROBOTS = 6
"""Vehicles that are moved for one: each more makes the search longer by as many times as there are waypoints."""

_Places = tuple[int, ...]


class Move(NamedTuple):
    """One vehicle drives one lane."""

    robot: Vehicle
    edge: Edge


@dataclass(eq=False)
class Resolution:
    """A deadlock that is being resolved.

    Attributes:
        first: The vehicle for which the others move.
        moves: The moves that are left, in order.
        robots: All vehicles that move, the first one first.
        held_back: Other vehicles that wait for what the moves that are left need.
    """

    first: Vehicle
    moves: list[Move]
    robots: list[Vehicle] = field(init=False)
    held_back: dict[Vehicle, None] = field(init=False, default_factory=dict)

    def __post_init__(self) -> None:
        """Note the vehicles that move."""
        self.robots = [*dict.fromkeys([self.first, *(move.robot for move in self.moves)])]


class Reservations:
    """The slots that the moves of resolutions need, which others that set out later don't enter until then.

    Args:
        near: The slots that touch each.
    """

    def __init__(self, near: Near) -> None:
        self._near = near
        self._by_slot: dict[int, list[Resolution]] = {}

    def add(self, resolution: Resolution) -> None:
        """Reserve what a resolution's moves need."""
        for move in resolution.moves:
            for slot in self._needed(move):
                self._by_slot.setdefault(slot, []).append(resolution)

    def remove(self, resolution: Resolution, moves: Sequence[Move]) -> None:
        """Reserve what some of its moves need no longer."""
        for move in moves:
            for slot in self._needed(move):
                there = self._by_slot[slot]
                there.remove(resolution)
                if not there:
                    del self._by_slot[slot]

    def _needed(self, move: Move) -> Iterator[int]:
        for slot in move.edge.leg.slots:
            yield slot
            yield from self._near.get(slot, ())

    def against(self, robot: Vehicle, slots: Iterable[int], first: Vehicle) -> Resolution | None:
        """Return a resolution that keeps a vehicle out of some slots, into which it is to go for the *first* one."""
        if not self._by_slot:
            return None
        order = rank(first)
        for slot in slots:
            for resolution in self._by_slot.get(slot, ()):
                if robot not in resolution.robots and rank(resolution.first) < order:
                    return resolution
        return None


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

    def find_moves(self, robot: Vehicle, target: int, max_states: int) -> list[Move] | None:
        """Return the fewest moves after which a vehicle is at a waypoint; None if none are found.

        The vehicles in its way enter the search one after the other, the nearest first.

        *max_states* is how many combinations of places are searched in all.
        """
        if self._slots.held(robot)[-1] >= len(self._admission.graph.lanes.out):
            # It stands in the middle of a lane, which only the vehicles before and behind it can leave.
            return None
        group = [robot]
        while len(group) < _MAX_ROBOTS and max_states > 0:
            joining = next(self._around(group, target), None)
            if joining is None:
                return None
            group.append(joining)
            moves, searched = self._search(group, target, max_states)
            if moves is not None:
                return moves
            max_states -= searched
        return None

    def _around(self, group: Sequence[Vehicle], target: int) -> Iterator[Vehicle]:
        """Yield the vehicles that may be moved, in breadth-first order from the target."""
        out, near = self._admission.graph.lanes.out, self._slots.near
        seen, todo = {target}, deque([target])
        while todo:
            node = todo.popleft()
            for other in sorted(self._slots.inside(node), key=rank):
                if other not in group and self._slots.held(other) == (node,) and self._movable(other, group[0]):
                    yield other
            for edge in out[node]:
                beside = (at for slot in edge.leg.slots for at in near.get(slot, ()) if at < len(out))
                for end in (edge.end, *beside):
                    if end not in seen:
                        seen.add(end)
                        todo.append(end)

    def _search(self, group: Sequence[Vehicle], target: int, max_states: int) -> tuple[list[Move] | None, int]:
        """Search the places of a group breadth first; return the moves, and how many combinations were searched."""
        start: _Places = tuple(self._slots.held(robot)[-1] for robot in group)
        before: dict[_Places, tuple[_Places, int, Edge] | None] = {start: None}
        todo = deque([start])
        while todo and len(before) < max_states:
            places = todo.popleft()
            if places[0] == target:
                return _moves(before, places, group), len(before)
            for i, place in enumerate(places):
                for edge in self._steps(group, i, place):
                    if edge.end in places or (self._slots.near and self._touches(group, i, edge, places)):
                        continue
                    after = (*places[:i], edge.end, *places[i + 1 :])
                    if after not in before:
                        before[after] = (places, i, edge)
                        todo.append(after)
        return None, len(before)

    def _touches(self, group: Sequence[Vehicle], i: int, edge: Edge, places: _Places) -> bool:
        """Return whether one of a group would touch another one of it on a lane."""
        touch, slots = self._slots.touch, edge.leg.slots
        return any(touch(group[i], slots, group[j], at) for j, at in enumerate(places) if j != i)

    def _steps(self, group: Sequence[Vehicle], i: int, place: int) -> Iterator[Edge]:
        """Yield the lanes from a waypoint on which only the group can be in the way of one of it."""
        slots, admission = self._slots, self._admission
        for edge in admission.graph.lanes.out[place]:
            lane = edge.leg.lane
            if not lane or self._reservations.against(group[i], edge.leg.slots, group[0]):
                continue
            others = (other for slot in edge.leg.slots for other in slots.in_the_way(group[i], slot))
            if admission.may_drive(group[i], lane) and all(other in group for other in others):
                yield edge


def _moves(
    before: dict[_Places, tuple[_Places, int, Edge] | None], places: _Places, group: Sequence[Vehicle]
) -> list[Move]:
    moves = []
    while (step := before[places]) is not None:
        places, i, edge = step
        moves.append(Move(group[i], edge))
    return moves[::-1]
