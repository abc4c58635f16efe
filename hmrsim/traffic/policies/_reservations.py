"""Reservations: the slots of a world, with the vehicles that hold each of them and those that wait for it.

Each waypoint and lane is a slot with a unique number. A vehicle that stands anywhere else, or is about to, holds a
*spot*: a slot that is added when needed, and is near the waypoints, lanes and spots around it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

from hmrsim.geometry import SAME_PLACE, distance
from hmrsim.traffic.nearness import touch

if TYPE_CHECKING:
    from hmrsim.geometry import Point
    from hmrsim.navigation.route import Leg
    from hmrsim.traffic.nearness import Near
    from hmrsim.traffic.rules import Vehicle

_NOTHING: Final[Mapping[Vehicle, Sequence[int]]] = MappingProxyType({})

_SPARE_SPOTS = 256
"""Spots to keep, in addition to four per vehicle, before unused ones are dropped."""


class Slots:
    """The slots of a world, including the spots of vehicles that stand away from waypoints.

    This is not built on simpy's resources, which would take five times as long.

    Args:
        capacities: The number of vehicles that may hold each slot at once: waypoints first, then lanes.
        waypoints: The number of waypoints.
        near: The slots in which vehicles may touch a vehicle in a slot, with the distance of each, by slot.
        around: Returns the waypoints and lanes in which vehicles may touch one at a point, with the distance of each.
        reach: The greatest sum of two vehicles' radii, in the world's unit.
        freed: Called with the vehicles that wait for slots that have just become free.
        reserved: Returns whether a slot will be needed although no vehicle holds it or waits for it.

    Attributes:
        near: The same as the argument, with the spots added.
        points: The position of each spot, by slot.
        free: The number of vehicles that may still enter each slot, regardless of nearby slots; less than 1 if it is
            full. Read-only; public because policies read it often.
        holders: The vehicles that hold each slot, in order of arrival. Read-only.
        changes: How often a vehicle has taken other slots: results for the present slots hold as long as it stays.
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
        self.changes = 0
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
        """Return the slots that a vehicle needs for a leg; the last one is where it stands at the end."""
        slots = leg.slots
        if not slots:
            return (self.spot(leg.end, shared=leg.shares_end),)
        if leg.leaves_for is None:
            # It may end in the middle of a lane.
            return slots if slots[-1] < self._waypoints else (self.spot(leg.end), *slots)
        return (self.spot(leg.leaves_for, shared=leg.shares_end), *slots)

    def destination(self, leg: Leg) -> int:
        """Return the slot where a vehicle stands after a leg."""
        return self.of(leg)[0 if leg.slots and leg.leaves_for is not None else -1]

    def is_lane(self, slot: int) -> bool:
        """Return whether a slot is a lane: neither a waypoint nor a spot."""
        return self._waypoints <= slot < self._first_spot

    def spot(self, point: Point, *, shared: bool = False) -> int:
        """Return the slot of a point away from waypoints; a *shared* one, such as a dock, has room for any number."""
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
            # Most spots are far away: compare coordinates first.
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
        """Drop unused spots, which would accumulate as clients may send robots to any point."""
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
        """Return the slots that a vehicle holds, in driving order."""
        return self._held.get(robot, ())

    def vehicles(self) -> Iterable[Vehicle]:
        """Return the vehicles that hold slots, in the order in which they entered the world."""
        return self._held

    def full(self, slot: int) -> bool:
        """Return whether a slot has no room for another vehicle."""
        return self.free[slot] < 1

    def room(self, slot: int, group: Sequence[Vehicle]) -> float:
        """Return the number of vehicles of a group for which a slot has room while all others stay."""
        return self.free[slot] + sum(other in group for other in self.holders[slot])

    def inside(self, slot: int) -> list[Vehicle]:
        """Return the vehicles that hold a slot, in order of arrival."""
        return self.holders[slot]

    def holders_near(self, slot: int, radius: float) -> Iterator[tuple[int, Vehicle]]:
        """Yield the vehicles that a vehicle of this radius in a slot would touch, each after its own slot."""
        for at, away in self.near.get(slot, {}).items():
            for other in self.holders[at]:
                if touch(away, radius + other.radius):
                    yield at, other

    def at_rest(self, idle: Callable[[Vehicle], bool]) -> bool:
        """Return whether all vehicles that hold slots stand or wait, and are *idle*."""
        return all((other.stands or other.waits) and idle(other) for inside in self.holders for other in inside)

    def missing(self, robot: Vehicle, slots: tuple[int, ...]) -> list[int]:
        """Return those of some slots that a vehicle neither holds nor can take now."""
        held, free, near = self._held.get(robot, ()), self.free, self.near
        if not near:
            return [slot for slot in slots if free[slot] < 1 and slot not in held]
        return [
            slot
            for slot in slots
            if slot not in held and (free[slot] < 1 or (slot in near and any(self.beside(robot, slot))))
        ]

    def in_the_way(self, robot: Vehicle, slot: int) -> Sequence[Vehicle]:
        """Return the vehicles because of which another can't take a slot now."""
        inside = self.holders[slot] if self.free[slot] < 1 else ()
        return [*inside, *self.beside(robot, slot)] if slot in self.near else inside

    def blockers(self, robot: Vehicle, slots: tuple[int, ...]) -> list[Vehicle]:
        """Return the vehicles because of which another can't take some slots now, each once."""
        held, free, near = self._held.get(robot, ()), self.free, self.near
        others: list[Vehicle] = []
        for slot in slots:
            if slot not in held and (free[slot] < 1 or slot in near):
                others += self.in_the_way(robot, slot)
        return [*dict.fromkeys(others)] if len(others) > 1 else others

    def beside(self, robot: Vehicle, slot: int) -> Iterator[Vehicle]:
        """Yield the vehicles that a vehicle in a slot would touch and does not touch already."""
        return (other for _, other in self._beside(robot, slot))

    def _beside(
        self, robot: Vehicle, slot: int, moving: Mapping[Vehicle, Sequence[int]] = _NOTHING
    ) -> Iterator[tuple[int, Vehicle]]:
        """Yield the same vehicles as `beside`, each after the slot that it holds.

        Vehicles that touch already are ignored: they could not separate otherwise.

        *moving* maps vehicles that change slots at this instant to their new slots.
        """
        for at, away in self.near.get(slot, {}).items():
            if slot in self._shared and at >= self._first_spot:
                continue
            inside = [other for other in self.holders[at] if other not in moving]
            inside += [other for other, slots in moving.items() if at in slots]
            for other in inside:
                if other is not robot and touch(away, robot.radius + other.radius) and not self._touches(robot, other):
                    yield at, other

    def _touches(self, robot: Vehicle, other: Vehicle) -> bool:
        return any(self.touch(robot, self._standing(robot), other, at) for at in self._standing(other))

    def _standing(self, robot: Vehicle) -> Sequence[int]:
        """Return the slots where a vehicle stands or is about to, without the lanes that it holds."""
        return [slot for slot in self.held(robot) if not self.is_lane(slot)]

    def touch(self, robot: Vehicle, slots: Iterable[int], other: Vehicle, at: int) -> bool:
        """Return whether a vehicle in any of *slots* would touch another one in the slot *at*."""
        radii = robot.radius + other.radius
        return any(at in near and touch(near[at], radii) for slot in slots if (near := self.near.get(slot)))

    def take(self, robot: Vehicle, leg: Leg) -> bool:
        """Give a vehicle the slots of a leg, and release all others.

        Returns:
            Whether it got them; if not, it waits for them and keeps its own.
        """
        free, inside, held, wanted = self.free, self.holders, self._held.get(robot, ()), leg.slots
        if not wanted or leg.leaves_for is not None or wanted[-1] >= self._waypoints:
            # Most legs lead from one waypoint to another.
            wanted = self.of(leg)
        near, crowded = self.near, False
        for slot in wanted:
            if slot in held:
                continue
            if free[slot] < 1:
                self._wanted.setdefault(slot, {})[robot] = None
                return False
            # Most slots have no slots near them.
            if near and slot in near:
                crowded = True
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
        """Return whether other vehicles are too near the slots that a vehicle wants; if so, make it wait for them."""
        taken: list[int] = []
        for slot in wanted:
            if slot in self.near and slot not in held:
                taken += [at for at, _ in self._beside(robot, slot)]
        for at in taken:
            self._wanted.setdefault(at, {})[robot] = None
        return bool(taken)

    def exchange(self, moves: Sequence[tuple[Vehicle, Sequence[int]]]) -> bool:
        """Move standing vehicles to new slots, all at once; return False and change nothing if there is no room."""
        free = self.free
        if not self._fit(moves):
            return False
        if self.near and self._collide(dict(moves)):
            return False
        self.changes += 1
        vacated = []
        for robot, slots in moves:
            for slot in self.held(robot):
                free[slot] += 1
                self.holders[slot].remove(robot)
                vacated.append(slot)
            self._held[robot] = tuple(slots)
        for robot, slots in moves:
            for slot in slots:
                free[slot] -= 1
                self.holders[slot].append(robot)
        for slot in vacated:
            if waiting := self._wanted.pop(slot, None):
                self._freed([*waiting])
        return True

    def _fit(self, moves: Sequence[tuple[Vehicle, Sequence[int]]]) -> bool:
        """Return whether the new slots of vehicles have room for them once they have all left their old ones."""
        after: dict[int, float] = {}
        for robot, slots in moves:
            for slot in self._held.get(robot, ()):
                after[slot] = after.get(slot, self.free[slot]) + 1
            for slot in slots:
                after[slot] = after.get(slot, self.free[slot]) - 1
        return all(after[slot] >= 0 for _, slots in moves for slot in slots)

    def _collide(self, moving: Mapping[Vehicle, Sequence[int]]) -> bool:
        """Return whether vehicles in their new slots would touch each other, or a vehicle that stays."""
        return any(any(self._beside(robot, slot, moving)) for robot, slots in moving.items() for slot in slots)

    def waiting_for(self, robot: Vehicle) -> list[Vehicle]:
        """Return the vehicles that wait for a slot which a vehicle holds, each once."""
        return [*dict.fromkeys(other for slot in self.held(robot) for other in self._wanted.get(slot, ()))]

    def watch(self, robot: Vehicle, slots: Collection[int]) -> None:
        """Make a waiting vehicle request again as soon as another leaves one of these slots or stops there."""
        self._unwatch(robot)
        if self.near:
            # The blocking vehicle may be in a nearby slot.
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
        """Give a standing vehicle these slots, even if they are full, and release all others.

        Away from waypoints, the vehicle also holds a spot.
        """
        if not slots or (len(slots) == 1 and self._waypoints <= slots[0] < self._first_spot):
            slots = (self.spot(robot.pose().point), *slots)
        held = self._held.get(robot, ())
        self._held[robot] = slots
        for slot in slots:
            if slot not in held:
                self.free[slot] -= 1
                self.holders[slot].append(robot)
        # Vehicles that wait for this one may now prefer another route.
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
        """Release the slots held except those kept, and make the vehicles that wait for released ones request again.

        If the vehicle *stays*, so do those that wait for the slots that it keeps.
        """
        self.changes += 1
        for slot in held:
            if slot not in kept:
                self.free[slot] += 1
                self.holders[slot].remove(robot)
            elif not stays:
                continue
            if slot in self._wanted and (waiting := self._wanted.pop(slot)):
                self._freed([*waiting])
