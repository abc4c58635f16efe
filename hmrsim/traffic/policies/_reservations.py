"""Who occupies which slots, and who waits for them."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

from hmrsim.geometry import SAME_PLACE, distance

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from hmrsim.geometry import Point
    from hmrsim.navigation.route import Leg
    from hmrsim.robots.vehicle import Mobile


class Slots:
    """The slots of a world, and the spots off the lanes where robots stand.

    simpy has resources for such things; they take five times as long, and most slots are free most of the time.

    Args:
        capacities: Of each slot, how many robots may be in it at once.
        freed: Called with those who wait for what has just become free.
    """

    def __init__(self, capacities: Sequence[float], freed: Callable[[Sequence[Mobile]], None]) -> None:
        self._free = [*capacities]
        self._inside: list[list[Mobile]] = [[] for _ in capacities]
        self._wanted: dict[int, dict[Mobile, None]] = {}
        self._spots: dict[Mobile, Point] = {}
        self._want_spots: dict[Mobile, None] = {}
        self._freed = freed

    def full(self, slot: int) -> bool:
        """Return whether nobody else may come into a slot."""
        return self._free[slot] < 1

    def inside(self, slot: int) -> list[Mobile]:
        """Return who occupies a slot, in order of coming."""
        return self._inside[slot]

    def at_rest(self, idle: Callable[[Mobile], bool]) -> bool:
        """Return whether all that occupy anything stand or wait, and are *idle*."""
        return all((other.stands or other.waits) and idle(other) for inside in self._inside for other in inside)

    def missing(self, robot: Mobile, slots: tuple[int, ...]) -> Iterator[int]:
        """Yield those of some slots that a robot does not have and can't have now."""
        return (slot for slot in slots if self._free[slot] < 1 and slot not in robot.slots)

    def on_spot(self, robot: Mobile, point: Point) -> Iterator[Mobile]:
        """Yield who stands, or is going to stand, off the lanes where a robot's footprint would be at a point."""
        for other, spot in self._spots.items():
            if other is not robot and distance(spot, point) < max(SAME_PLACE, robot.radius + other.radius):
                yield other

    def take(self, robot: Mobile, leg: Leg) -> bool:
        """Have a robot occupy the slots of a leg, or its end if that is off the lanes, and nothing else any more.

        Returns:
            Whether it may; if not, nothing has changed but that it waits.
        """
        free, inside, held, wanted = self._free, self._inside, robot.slots, leg.slots
        for slot in wanted:
            if free[slot] < 1 and slot not in held:
                self._wanted.setdefault(slot, {})[robot] = None
                return False
        if not (wanted or self._take_spot(robot, leg)):
            return False
        for slot in wanted:
            if slot not in held:
                free[slot] -= 1
                inside[slot].append(robot)
        robot.slots = wanted
        for slot in held:
            if slot not in wanted:
                self._leave(robot, slot)
        if wanted and self._spots:
            self._leave_spot(robot)
        return True

    def _take_spot(self, robot: Mobile, leg: Leg) -> bool:
        if not leg.shares_end and next(self.on_spot(robot, leg.end), None) is not None:
            self._want_spots[robot] = None
            return False
        self._leave_spot(robot)
        self._spots[robot] = leg.end
        return True

    def exchange(self, moves: Sequence[tuple[Mobile, Leg]]) -> bool:
        """Have robots that stand occupy the slots of their legs, all at once; return whether there is room for all."""
        free = self._free
        gone = Counter(slot for robot, _ in moves for slot in robot.slots)
        come = Counter(slot for _, leg in moves for slot in leg.slots)
        if any(free[slot] + gone[slot] < number for slot, number in come.items()):
            return False
        left = []
        for robot, leg in moves:
            for slot in robot.slots:
                free[slot] += 1
                self._inside[slot].remove(robot)
                left.append(slot)
            robot.slots = leg.slots
        for robot, leg in moves:
            for slot in leg.slots:
                free[slot] -= 1
                self._inside[slot].append(robot)
        for slot in left:
            if waiting := self._wanted.pop(slot, None):
                self._freed([*waiting])
        return True

    def stand(self, robot: Mobile, slots: tuple[int, ...]) -> None:
        """Have a robot that stands occupy these slots, or its spot, and nothing else any more, whoever is there."""
        held = robot.slots
        robot.slots = slots
        for slot in slots:
            if slot not in held:
                self._free[slot] -= 1
                self._inside[slot].append(robot)
        self._leave_spot(robot)
        if not slots:
            self._spots[robot] = robot.pose().point
        for slot in held:
            if slot not in slots:
                self._leave(robot, slot)
            elif waiting := self._wanted.pop(slot, None):
                # They may not want to wait for one that stays.
                self._freed([*waiting])

    def leave(self, robot: Mobile) -> None:
        """Let go of all that a robot occupies."""
        held, robot.slots = robot.slots, ()
        self._leave_spot(robot)
        for slot in held:
            self._leave(robot, slot)

    def forget(self, robot: Mobile, leg: Leg) -> None:
        """Let a robot wait for a leg no longer."""
        for slot in leg.slots:
            self._wanted.get(slot, {}).pop(robot, None)
        self._want_spots.pop(robot, None)

    def _leave(self, robot: Mobile, slot: int) -> None:
        self._free[slot] += 1
        self._inside[slot].remove(robot)
        waiting = self._wanted.pop(slot, None)
        if waiting:
            self._freed([*waiting])

    def _leave_spot(self, robot: Mobile) -> None:
        if self._spots.pop(robot, None) is not None and self._want_spots:
            waiting, self._want_spots = self._want_spots, {}
            self._freed([*waiting])
