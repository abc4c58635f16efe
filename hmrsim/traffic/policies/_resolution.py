"""Resolutions of deadlocks: steps in which vehicles move, and the places that are reserved or claimed for them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from hmrsim.traffic.policies._admission import Vehicle
    from hmrsim.traffic.policies._nearness import Near
    from hmrsim.traffic.policies._reservations import Slots
    from hmrsim.traffic.policies._ways import Way


class Move(NamedTuple):
    """One vehicle drives one way.

    Attributes:
        start: The slot where it stands before.
    """

    robot: Vehicle
    way: Way
    start: int


Step = Sequence[Move]
"""One move, or those of a circle of vehicles that move on all at once."""


@dataclass(eq=False)
class Resolution:
    """A deadlock that is being resolved.

    Steps that have nothing to do with each other are made at the same time: a step begins as soon as its vehicles have
    made their earlier moves, and none of the earlier steps that are left needs a slot of it.

    Attributes:
        first: The vehicle for which the others move.
        steps: The steps that are left, in order.
        moving: The vehicles that are on their way, and which one drives.
        robots: All vehicles that move, the first one first.
        held_back: Other vehicles that wait for what the steps that are left need.
    """

    first: Vehicle
    steps: list[Step]
    moving: dict[Vehicle, Way] = field(init=False, default_factory=dict)
    robots: list[Vehicle] = field(init=False)
    held_back: dict[Vehicle, None] = field(init=False, default_factory=dict)

    def __post_init__(self) -> None:
        """Note the vehicles that move."""
        self.robots = [*dict.fromkeys([self.first, *(move.robot for step in self.steps for move in step)])]

    def ready(self, near: Near) -> list[Step]:
        """Return the steps that need not wait for others, in order."""
        busy, found = {*self.moving}, list[Step]()
        taken = {slot for way in self.moving.values() for slot in way.slots}
        for step in self.steps:
            robots = {move.robot for move in step}
            needed = {slot for move in step for slot in (move.start, *move.way.slots)}
            around = {at for slot in needed for at in near.get(slot, ())}
            if busy.isdisjoint(robots) and taken.isdisjoint(needed) and taken.isdisjoint(around):
                found.append(step)
            busy |= robots
            taken |= needed
        return found

    def begin(self, step: Step) -> None:
        """Record that the vehicles of a step set out."""
        self.steps.remove(step)
        self.moving.update((move.robot, move.way) for move in step)


class Reservations:
    """The slots that the steps of resolutions need, which others that set out later don't enter until then.

    Args:
        near: The slots that touch each.
    """

    def __init__(self, near: Near) -> None:
        self._near = near
        self._by_slot: dict[int, list[Resolution]] = {}

    def add(self, resolution: Resolution) -> None:
        """Reserve what a resolution's steps need."""
        for slot in self._needed(resolution.steps):
            self._by_slot.setdefault(slot, []).append(resolution)

    def remove(self, resolution: Resolution, steps: Iterable[Step]) -> None:
        """Reserve what some of its steps need no longer."""
        for slot in self._needed(steps):
            there = self._by_slot[slot]
            there.remove(resolution)
            if not there:
                del self._by_slot[slot]

    def __contains__(self, slot: int) -> bool:
        """Return whether a resolution needs a slot."""
        return slot in self._by_slot

    def _needed(self, steps: Iterable[Step]) -> Iterator[int]:
        return (slot for step in steps for move in step for slot in move.way.slots)

    def against(self, robot: Vehicle, slots: Iterable[int], first: Vehicle) -> Resolution | None:
        """Return a resolution that keeps a vehicle out of some slots, into which it is to go for the *first* one."""
        if not self._by_slot:
            return None
        order, by_slot, near = first.rank, self._by_slot, self._near
        for slot in slots:
            for at in (slot, *near.get(slot, ())) if near else (slot,):
                for resolution in by_slot.get(at, ()):
                    if robot not in resolution.robots and resolution.first.rank < order:
                        return resolution
        return None


AFTER = 20.0
"""Simulated seconds after which the vehicle that set out first keeps others out of what it needs."""


class Claim:
    """The slots that one vehicle at a time claims; vehicles that set out later don't enter them.

    Args:
        slots: The slots of the world.
        released: Called with the vehicles that were kept out, when the claim is over.

    Attributes:
        holder: The vehicle; None if none claims anything.
    """

    def __init__(self, slots: Slots, released: Callable[[Sequence[Vehicle]], None]) -> None:
        self.holder: Vehicle | None = None
        self._slots = slots
        self._released = released
        self._claimed: dict[int, None] = {}
        self._kept_out: dict[Vehicle, None] = {}

    def extend(self, robot: Vehicle, slots: Iterable[int]) -> None:
        """Claim slots for a vehicle, instead of those of the one that claims now if that is another one."""
        if robot is not self.holder:
            self.end()
            self.holder = robot
        self._claimed.update(dict.fromkeys(slots))

    def end(self) -> None:
        """Clear the claim."""
        self.holder = None
        self._claimed.clear()
        kept_out, self._kept_out = self._kept_out, {}
        if kept_out:
            self._released([*kept_out])

    def excludes(self, robot: Vehicle, slots: Iterable[int], order: tuple[float, str]) -> bool:
        """Return whether a vehicle may not enter slots, into which it would go for one of this rank."""
        first = self.holder
        if first is None or robot is first or order <= first.rank:
            return False
        held = self._slots.held(robot)
        return any(slot in self._claimed and slot not in held for slot in slots)

    def keeps_out(self, robot: Vehicle, slots: Iterable[int]) -> bool:
        """Return whether a vehicle may not enter slots; then it asks again when the claim is over."""
        if not self.excludes(robot, slots, robot.rank):
            return False
        self._kept_out[robot] = None
        return True

    def forget(self, robot: Vehicle) -> None:
        """Forget a vehicle that has left the world."""
        self._kept_out.pop(robot, None)
