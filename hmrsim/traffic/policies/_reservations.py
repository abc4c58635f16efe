"""Reservations: the vehicles that hold each slot, and those that wait for it.

Waypoints and lanes are slots, each with a unique number. A vehicle that stands anywhere else, or is going to, holds a
*spot*: a slot that is made when it is first needed, and touches the waypoints, lanes and spots around it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

from hmrsim.geometry import SAME_PLACE, distance
from hmrsim.traffic.policies._nearness import touch

if TYPE_CHECKING:
    from hmrsim.geometry import Point
    from hmrsim.navigation.route import Leg
    from hmrsim.traffic.policies._nearness import Near
    from hmrsim.traffic.rules import Vehicle

_NOTHING: Final[Mapping[Vehicle, Sequence[int]]] = MappingProxyType({})


_SPARE_SPOTS = 256
"""Spots that are kept although no vehicle needs them now, beside four for each vehicle."""


class Slots:
    """The slots of a world, and the spots where vehicles stand that are at no waypoint.

    simpy has resources for this; they take five times as long, and most slots are free most of the time.

    Args:
        capacities: Of each slot, how many vehicles may hold it at once: first waypoints, then lanes.
        waypoints: How many of these are waypoints.
        near: The slots that a vehicle may have only while no other one is so near that their footprints touch.
        around: Returns the waypoints and lanes that a vehicle at a point may touch, and how far away each is.
        reach: The greatest sum of two vehicles' radii, in the world's unit.
        freed: Called with the vehicles that wait for slots that have just become free.
        reserved: Whether a slot is going to be needed although no vehicle holds it or waits for it.

    Attributes:
        near: As given, with the spots.
        points: Where each spot is, by its slot.
        free: How many more vehicles may come into each slot, as far as the slots near it allow; less than 1 where it is
            full. To be read only, as it is many times a lane.
        holders: The vehicles that hold each slot, in the order in which they came. To be read only, too.
    """

    def __init__(
        self,
        capacities: Sequence[float],
        waypoints: int,
        near: Near,
        *,
        around: Callable[[Point], Mapping[int, float]],
        reach: float,
        freed: Callable[[Sequence[Vehicle]], None],
        reserved: Callable[[int], bool],
    ) -> None:
        self.near = {**near}
        self.points: dict[int, Point] = {}
        self.free = [*capacities]
        self.holders: list[list[Vehicle]] = [[] for _ in capacities]
        self._held: dict[Vehicle, tuple[int, ...]] = {}
        self._wanted: dict[int, dict[Vehicle, None]] = {}
        self._watched: dict[Vehicle, Collection[int]] = {}
        self._waypoints, self._first_spot = waypoints, len(capacities)
        self._spots: dict[tuple[Point, bool], int] = {}
        self._shared: set[int] = set()
        self._unused: list[int] = []
        self._around = around
        self._reach = max(SAME_PLACE, reach)
        self._freed = freed
        self._reserved = reserved

    def of(self, leg: Leg) -> tuple[int, ...]:
        """Return the slots that a vehicle needs for a leg; the last one is where it stands at its end."""
        slots = leg.slots
        if not slots:
            return (self.spot(leg.end, shared=leg.shares_end),)
        if leg.leaves_for is None:
            # It may end in the middle of a lane.
            return slots if slots[-1] < self._waypoints else (self.spot(leg.end), *slots)
        return (self.spot(leg.leaves_for, shared=leg.shares_end), *slots)

    def destination(self, leg: Leg) -> int:
        """Return the slot where a vehicle stands that has driven a leg, and has left the lanes if it does so next."""
        return self.of(leg)[0 if leg.slots and leg.leaves_for is not None else -1]

    def is_lane(self, slot: int) -> bool:
        """Return whether a slot is a lane: neither a waypoint nor a spot."""
        return self._waypoints <= slot < self._first_spot

    def spot(self, point: Point, *, shared: bool = False) -> int:
        """Return the slot of a point that is no waypoint; a *shared* one is for any number, such as a dock."""
        slot = self._spots.get((point, shared))
        if slot is None:
            slot = self._add_spot(point, shared=shared)
        return slot

    def _add_spot(self, point: Point, *, shared: bool) -> int:
        if len(self._spots) > _SPARE_SPOTS + 4 * len(self._held):
            self._drop_spots()
        room = math.inf if shared else 1.0
        if self._unused:
            slot = self._unused.pop()
            self.free[slot] = room
        else:
            slot = len(self.free)
            self.free.append(room)
            self.holders.append([])
        near, (x, y), reach = {**self._around(point)}, point, self._reach
        for other, at in self.points.items():
            # Most are nowhere near.
            if -reach < at[0] - x < reach and -reach < at[1] - y < reach and (away := distance(point, at)) < reach:
                near[other] = away
        self._spots[point, shared] = slot
        self.points[slot] = point
        if shared:
            self._shared.add(slot)
        if near:
            self.near[slot] = near
            for other, away in near.items():
                self.near[other] = {**self.near.get(other, {}), slot: away}
        return slot

    def _drop_spots(self) -> None:
        """Forget unused spots: clients may send robots to any point, so spots would pile up."""
        for key, slot in [*self._spots.items()]:
            if self.holders[slot] or self._wanted.get(slot) or self._reserved(slot):
                continue
            del self._spots[key], self.points[slot]
            self._shared.discard(slot)
            self._wanted.pop(slot, None)
            self._unused.append(slot)
            for other in self.near.pop(slot, ()):
                left = {at: away for at, away in self.near[other].items() if at != slot}
                if left:
                    self.near[other] = left
                else:
                    del self.near[other]

    def held(self, robot: Vehicle) -> tuple[int, ...]:
        """Return the slots that a vehicle holds, in the order in which it drives them."""
        return self._held.get(robot, ())

    def vehicles(self) -> Iterable[Vehicle]:
        """Return the vehicles that hold slots, in the order in which they came into the world."""
        return self._held

    def full(self, slot: int) -> bool:
        """Return whether no other vehicle may come into a slot."""
        return self.free[slot] < 1

    def room(self, slot: int, group: Sequence[Vehicle]) -> float:
        """Return how many vehicles of a group may hold a slot while all others stay."""
        return self.free[slot] + sum(other in group for other in self.holders[slot])

    def inside(self, slot: int) -> list[Vehicle]:
        """Return the vehicles that hold a slot, in the order in which they came."""
        return self.holders[slot]

    def holders_near(self, slot: int, radius: float) -> Iterator[tuple[int, Vehicle]]:
        """Yield the slots so near to one, and who holds them, that a vehicle of this radius there would touch it."""
        for at, away in self.near.get(slot, {}).items():
            for other in self.holders[at]:
                if touch(away, radius + other.radius):
                    yield at, other

    def at_rest(self, idle: Callable[[Vehicle], bool]) -> bool:
        """Return whether all vehicles that hold anything stand or wait, and are *idle*."""
        return all((other.stands or other.waits) and idle(other) for inside in self.holders for other in inside)

    def missing(self, robot: Vehicle, slots: tuple[int, ...]) -> list[int]:
        """Return those of some slots that a vehicle does not hold and can't have now."""
        held, free, near = self._held.get(robot, ()), self.free, self.near
        if not near:
            return [slot for slot in slots if free[slot] < 1 and slot not in held]
        return [
            slot
            for slot in slots
            if slot not in held and (free[slot] < 1 or (slot in near and any(self.beside(robot, slot))))
        ]

    def in_the_way(self, robot: Vehicle, slot: int) -> Sequence[Vehicle]:
        """Return the vehicles because of which one that does not hold a slot can't have it now."""
        inside = self.holders[slot] if self.free[slot] < 1 else ()
        return [*inside, *self.beside(robot, slot)] if slot in self.near else inside

    def blockers(self, robot: Vehicle, slots: tuple[int, ...]) -> list[Vehicle]:
        """Return the vehicles because of which one can't have some slots now, each once."""
        held, free, near = self._held.get(robot, ()), self.free, self.near
        found: list[Vehicle] = []
        for slot in slots:
            if slot not in held and (free[slot] < 1 or slot in near):
                found += self.in_the_way(robot, slot)
        return [*dict.fromkeys(found)] if len(found) > 1 else found

    def beside(self, robot: Vehicle, slot: int) -> Iterator[Vehicle]:
        """Yield the vehicles that a vehicle in a slot would touch from the slots near it."""
        return (other for _, other in self._beside(robot, slot))

    def _beside(
        self, robot: Vehicle, slot: int, moving: Mapping[Vehicle, Sequence[int]] = _NOTHING
    ) -> Iterator[tuple[int, Vehicle]]:
        """Yield the slots near one and the vehicles there that one in it would touch, but for those it touches already.

        Vehicles that were put where they touch could not leave each other otherwise.

        *moving* are the slots of those that leave theirs at this instant.
        """
        for at, away in self.near.get(slot, {}).items():
            if slot in self._shared and at >= self._first_spot:
                continue
            there = [other for other in self.holders[at] if other not in moving]
            there += [other for other, slots in moving.items() if at in slots]
            for other in there:
                if other is not robot and touch(away, robot.radius + other.radius) and not self._touches(robot, other):
                    yield at, other

    def _touches(self, robot: Vehicle, other: Vehicle) -> bool:
        return any(self.touch(robot, self._standing(robot), other, at) for at in self._standing(other))

    def _standing(self, robot: Vehicle) -> Sequence[int]:
        """Return where a vehicle stands or is going to: in the middle of a lane it holds all of that, too."""
        return [slot for slot in self.held(robot) if not self.is_lane(slot)]

    def touch(self, robot: Vehicle, slots: Iterable[int], other: Vehicle, at: int) -> bool:
        """Return whether a vehicle in one of some slots touches another one in the slot *at*, which is none of them."""
        radii = robot.radius + other.radius
        return any(at in near and touch(near[at], radii) for slot in slots if (near := self.near.get(slot)))

    def take(self, robot: Vehicle, leg: Leg) -> bool:
        """Give a vehicle the slots of a leg, and release all others.

        Returns:
            Whether it may have them; if not, nothing has changed but that it waits.
        """
        free, inside, held, wanted = self.free, self.holders, self._held.get(robot, ()), self.of(leg)
        crowded = False
        for slot in wanted:
            if slot in held:
                continue
            if free[slot] < 1:
                self._wanted.setdefault(slot, {})[robot] = None
                return False
            # Most slots are near no other.
            crowded = crowded or slot in self.near
        if crowded and self._waits_beside(robot, wanted, held):
            return False
        for slot in wanted:
            if slot not in held:
                free[slot] -= 1
                inside[slot].append(robot)
        self._held[robot] = wanted
        self._release(robot, held, wanted)
        return True

    def _waits_beside(self, robot: Vehicle, wanted: tuple[int, ...], held: tuple[int, ...]) -> bool:
        """Return whether others are too near the slots that a vehicle wants; then it waits for all of them to leave."""
        taken: list[int] = []
        for slot in wanted:
            if slot in self.near and slot not in held:
                taken += [at for at, _ in self._beside(robot, slot)]
        for at in taken:
            self._wanted.setdefault(at, {})[robot] = None
        return bool(taken)

    def exchange(self, moves: Sequence[tuple[Vehicle, Sequence[int]]]) -> bool:
        """Give vehicles that stand the slots that they move to, all at once; return whether there is room for all."""
        free = self.free
        if not self._fit(moves):
            return False
        if self.near and self._collide(dict(moves)):
            return False
        left = []
        for robot, slots in moves:
            for slot in self.held(robot):
                free[slot] += 1
                self.holders[slot].remove(robot)
                left.append(slot)
            self._held[robot] = tuple(slots)
        for robot, slots in moves:
            for slot in slots:
                free[slot] -= 1
                self.holders[slot].append(robot)
        for slot in left:
            if waiting := self._wanted.pop(slot, None):
                self._freed([*waiting])
        return True

    def _fit(self, moves: Sequence[tuple[Vehicle, Sequence[int]]]) -> bool:
        """Return whether there is room for vehicles that go to these slots at once, and leave those that they hold."""
        after: dict[int, float] = {}
        for robot, slots in moves:
            for slot in self._held.get(robot, ()):
                after[slot] = after.get(slot, self.free[slot]) + 1
            for slot in slots:
                after[slot] = after.get(slot, self.free[slot]) - 1
        return all(after[slot] >= 0 for _, slots in moves for slot in slots)

    def _collide(self, moving: Mapping[Vehicle, Sequence[int]]) -> bool:
        """Return whether vehicles that move to these slots at once would touch each other, or one that stays."""
        return any(any(self._beside(robot, slot, moving)) for robot, slots in moving.items() for slot in slots)

    def watch(self, robot: Vehicle, slots: Collection[int]) -> None:
        """Make a waiting vehicle request again when another leaves one of these slots, or comes to rest there."""
        self._unwatch(robot)
        if self.near:
            # What is in the way may be beside them.
            beside = [at for slot in slots for at in self.near.get(slot, ()) if self.holders[at]]
            slots = dict.fromkeys([*slots, *beside])
        self._watched[robot] = slots
        wanted = self._wanted
        for slot in slots:
            waiting = wanted.get(slot)
            if waiting is None:
                wanted[slot] = {robot: None}
            else:
                waiting[robot] = None

    def _unwatch(self, robot: Vehicle) -> None:
        for slot in self._watched.pop(robot, ()):
            waiting = self._wanted.get(slot)
            if waiting:
                waiting.pop(robot, None)

    def stand(self, robot: Vehicle, slots: tuple[int, ...]) -> None:
        """Give a vehicle that stands these slots, also full ones, and release all others.

        Away from the waypoints it also holds its spot.
        """
        if not slots or (len(slots) == 1 and self._waypoints <= slots[0] < self._first_spot):
            slots = (self.spot(robot.pose().point), *slots)
        held = self._held.get(robot, ())
        self._held[robot] = slots
        for slot in slots:
            if slot not in held:
                self.free[slot] -= 1
                self.holders[slot].append(robot)
        # A vehicle that waits for one that stays may prefer another route.
        self._release(robot, held, slots, stays=True)

    def leave(self, robot: Vehicle) -> None:
        """Release all slots of a vehicle."""
        self._release(robot, self._held.pop(robot, ()))

    def forget(self, robot: Vehicle, leg: Leg) -> None:
        """End the wait of a vehicle for a leg."""
        wanted, near = self._wanted, self.near
        for slot in self.of(leg):
            for at in (slot, *near.get(slot, ())) if near else (slot,):
                if waiting := wanted.get(at):
                    waiting.pop(robot, None)
        if robot in self._watched:
            self._unwatch(robot)

    def _release(self, robot: Vehicle, held: Sequence[int], kept: Sequence[int] = (), *, stays: bool = False) -> None:
        """Release the slots held but for those that are kept; who waits for one asks again, for all if it *stays*."""
        for slot in held:
            if slot not in kept:
                self.free[slot] += 1
                self.holders[slot].remove(robot)
            elif not stays:
                continue
            if slot in self._wanted and (waiting := self._wanted.pop(slot)):
                self._freed([*waiting])
