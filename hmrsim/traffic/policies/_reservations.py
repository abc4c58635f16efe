"""Which vehicles hold which slots, and which wait for them."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

from hmrsim.geometry import SAME_PLACE, distance
from hmrsim.traffic.policies._nearness import touch

if TYPE_CHECKING:
    from hmrsim.geometry import Point
    from hmrsim.navigation.route import Leg
    from hmrsim.traffic.policies._nearness import Near
    from hmrsim.traffic.policies._vehicle import Vehicle

_NOTHING: Final[Mapping[Vehicle, Sequence[int]]] = MappingProxyType({})


class Slots:
    """The slots of a world, and the spots off the lanes where vehicles stand.

    simpy has resources for this; they take five times as long, and most slots are free most of the time.

    Args:
        capacities: Of each slot, how many vehicles may hold it at once.
        near: The slots that a vehicle may have only while no other one is so near that their footprints touch.
        freed: Called with the vehicles that wait for slots that have just become free.

    Attributes:
        near: As given.
    """

    def __init__(self, capacities: Sequence[float], near: Near, freed: Callable[[Sequence[Vehicle]], None]) -> None:
        self.near = near
        self._free = [*capacities]
        self._inside: list[list[Vehicle]] = [[] for _ in capacities]
        self._held: dict[Vehicle, tuple[int, ...]] = {}
        self._wanted: dict[int, dict[Vehicle, None]] = {}
        self._watched: dict[Vehicle, Collection[int]] = {}
        self._spots: dict[Vehicle, Point] = {}
        self._want_spots: dict[Vehicle, None] = {}
        self._freed = freed

    def held(self, robot: Vehicle) -> tuple[int, ...]:
        """Return the slots that a vehicle holds, in the order in which it drives them."""
        return self._held.get(robot, ())

    def full(self, slot: int) -> bool:
        """Return whether no other vehicle may come into a slot."""
        return self._free[slot] < 1

    def room(self, slot: int, group: Sequence[Vehicle]) -> float:
        """Return how many vehicles of a group may hold a slot while all others stay."""
        return self._free[slot] + sum(other in group for other in self._inside[slot])

    def inside(self, slot: int) -> list[Vehicle]:
        """Return the vehicles that hold a slot, in the order in which they came."""
        return self._inside[slot]

    def holders_near(self, slot: int, radius: float) -> Iterator[tuple[int, Vehicle]]:
        """Yield the slots so near to one, and who holds them, that a vehicle of this radius there would touch it."""
        for at, away in self.near.get(slot, {}).items():
            for other in self._inside[at]:
                if touch(away, radius + other.radius):
                    yield at, other

    def held_alone(self, first: int) -> list[int]:
        """Return the slots from a number on that are all that some vehicle holds, in order."""
        return sorted({held[0] for held in self._held.values() if len(held) == 1 and held[0] >= first})

    def at_rest(self, idle: Callable[[Vehicle], bool]) -> bool:
        """Return whether all vehicles that hold anything stand or wait, and are *idle*."""
        return all((other.stands or other.waits) and idle(other) for inside in self._inside for other in inside)

    def missing(self, robot: Vehicle, slots: tuple[int, ...]) -> Iterator[int]:
        """Yield those of some slots that a vehicle does not hold and can't have now."""
        held = self._held.get(robot, ())
        for slot in slots:
            if slot not in held and (self._free[slot] < 1 or (slot in self.near and any(self.beside(robot, slot)))):
                yield slot

    def in_the_way(self, robot: Vehicle, slot: int) -> Iterator[Vehicle]:
        """Yield the vehicles because of which one that does not hold a slot can't have it now."""
        if self._free[slot] < 1:
            yield from self._inside[slot]
        if slot in self.near:
            yield from self.beside(robot, slot)

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
            there = [other for other in self._inside[at] if other not in moving]
            there += [other for other, slots in moving.items() if at in slots]
            for other in there:
                if other is not robot and touch(away, robot.radius + other.radius) and not self._touches(robot, other):
                    yield at, other

    def _touches(self, robot: Vehicle, other: Vehicle) -> bool:
        return any(self.touch(robot, self.held(robot), other, at) for at in self.held(other))

    def touch(self, robot: Vehicle, slots: Iterable[int], other: Vehicle, at: int) -> bool:
        """Return whether a vehicle in one of some slots touches another one in the slot *at*, which is none of them."""
        radii = robot.radius + other.radius
        return any(at in near and touch(near[at], radii) for slot in slots if (near := self.near.get(slot)))

    def on_spot(self, robot: Vehicle, point: Point) -> Iterator[Vehicle]:
        """Yield the vehicles that stand off the lanes, now or soon, where a vehicle's footprint would be at a point."""
        for other, spot in self._spots.items():
            if other is not robot and distance(spot, point) < max(SAME_PLACE, robot.radius + other.radius):
                yield other

    def take(self, robot: Vehicle, leg: Leg) -> bool:
        """Give a vehicle the slots of a leg, or its end if that is off the lanes, and release all others.

        Returns:
            Whether it may have them; if not, nothing has changed but that it waits.
        """
        free, inside, held, wanted = self._free, self._inside, self._held.get(robot, ()), leg.slots
        for slot in wanted:
            if free[slot] < 1 and slot not in held:
                self._wanted.setdefault(slot, {})[robot] = None
                return False
        if self.near and self._waits_beside(robot, wanted):
            return False
        if not (wanted or self._take_spot(robot, leg)):
            return False
        for slot in wanted:
            if slot not in held:
                free[slot] -= 1
                inside[slot].append(robot)
        self._held[robot] = wanted
        for slot in held:
            if slot not in wanted:
                self._release(robot, slot)
        if wanted and self._spots:
            self._leave_spot(robot)
        return True

    def _waits_beside(self, robot: Vehicle, wanted: tuple[int, ...]) -> bool:
        """Return whether others are too near the slots that a vehicle wants; then it waits for all of them to leave."""
        held = self._held.get(robot, ())
        taken = [at for slot in wanted if slot not in held for at, _ in self._beside(robot, slot)]
        for at in taken:
            self._wanted.setdefault(at, {})[robot] = None
        return bool(taken)

    def _take_spot(self, robot: Vehicle, leg: Leg) -> bool:
        if not leg.shares_end and next(self.on_spot(robot, leg.end), None) is not None:
            self._want_spots[robot] = None
            return False
        self._leave_spot(robot)
        self._spots[robot] = leg.end
        return True

    def exchange(self, moves: Sequence[tuple[Vehicle, Leg]]) -> bool:
        """Give vehicles that stand the slots of their legs, all at once; return whether there is room for all."""
        free = self._free
        if not self._fit(moves):
            return False
        if self.near and self._collide({robot: leg.slots for robot, leg in moves}):
            return False
        left = []
        for robot, leg in moves:
            for slot in self.held(robot):
                free[slot] += 1
                self._inside[slot].remove(robot)
                left.append(slot)
            self._held[robot] = leg.slots
        for robot, leg in moves:
            for slot in leg.slots:
                free[slot] -= 1
                self._inside[slot].append(robot)
        for slot in left:
            if waiting := self._wanted.pop(slot, None):
                self._freed([*waiting])
        return True

    def _fit(self, moves: Sequence[tuple[Vehicle, Leg]]) -> bool:
        """Return whether there is room for vehicles that go to these slots at once, and leave those that they hold."""
        after: dict[int, float] = {}
        for robot, leg in moves:
            for slot in self._held.get(robot, ()):
                after[slot] = after.get(slot, self._free[slot]) + 1
            for slot in leg.slots:
                after[slot] = after.get(slot, self._free[slot]) - 1
        return all(after[slot] >= 0 for _, leg in moves for slot in leg.slots)

    def _collide(self, moving: Mapping[Vehicle, Sequence[int]]) -> bool:
        """Return whether vehicles that move to these slots at once would touch each other, or one that stays."""
        return any(any(self._beside(robot, slot, moving)) for robot, slots in moving.items() for slot in slots)

    def watch(self, robot: Vehicle, slots: Collection[int]) -> None:
        """Have a vehicle that waits ask again when a vehicle leaves one of these slots, or stands there from now on."""
        self._unwatch(robot)
        self._watched[robot] = slots
        wanted = self._wanted
        for slot in slots:
            wanted.setdefault(slot, {})[robot] = None

    def _unwatch(self, robot: Vehicle) -> None:
        for slot in self._watched.pop(robot, ()):
            waiting = self._wanted.get(slot)
            if waiting:
                waiting.pop(robot, None)

    def stand(self, robot: Vehicle, slots: tuple[int, ...]) -> None:
        """Give a vehicle that stands these slots, also full ones, or its spot, and release all others."""
        held = self._held.get(robot, ())
        self._held[robot] = slots
        for slot in slots:
            if slot not in held:
                self._free[slot] -= 1
                self._inside[slot].append(robot)
        self._leave_spot(robot)
        if not slots:
            self._spots[robot] = robot.pose().point
        for slot in held:
            if slot not in slots:
                self._release(robot, slot)
            elif waiting := self._wanted.pop(slot, None):
                # A vehicle that waits for one that stays may prefer another route.
                self._freed([*waiting])

    def leave(self, robot: Vehicle) -> None:
        """Release all slots of a vehicle."""
        held = self._held.pop(robot, ())
        self._leave_spot(robot)
        for slot in held:
            self._release(robot, slot)

    def forget(self, robot: Vehicle, leg: Leg) -> None:
        """Let a vehicle wait for a leg no longer."""
        for slot in leg.slots:
            for at in (slot, *self.near.get(slot, ())):
                self._wanted.get(at, {}).pop(robot, None)
        if robot in self._watched:
            self._unwatch(robot)
        self._want_spots.pop(robot, None)

    def _release(self, robot: Vehicle, slot: int) -> None:
        self._free[slot] += 1
        self._inside[slot].remove(robot)
        if self._wanted and (waiting := self._wanted.pop(slot, None)):
            self._freed([*waiting])

    def _leave_spot(self, robot: Vehicle) -> None:
        if self._spots.pop(robot, None) is not None and self._want_spots:
            waiting, self._want_spots = self._want_spots, {}
            self._freed([*waiting])
