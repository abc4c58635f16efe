"""Resolutions of deadlocks: steps in which vehicles move, and the places that are reserved or claimed for them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

from hmrsim.traffic.rules import by_rank

if TYPE_CHECKING:
    from hmrsim.navigation.route import Leg
    from hmrsim.traffic.admission import Admission
    from hmrsim.traffic.nearness import Near
    from hmrsim.traffic.policies._reservations import Slots
    from hmrsim.traffic.policies._ways import Way, Ways
    from hmrsim.traffic.rules import Vehicle


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


class Resolutions:
    """The deadlocks that are being resolved, and the slots that the steps which are left need.

    Vehicles that set out later don't enter these slots until then.

    Args:
        slots: The places of the vehicles.
        ways: Where they can go.
        claim: Keeps vehicles out of what one needs that set out before them.

    Attributes:
        by_robot: The resolution of which each vehicle is a part, if any. To be read only.
    """

    def __init__(self, admission: Admission, slots: Slots, ways: Ways, claim: Claim) -> None:
        self.by_robot: dict[Vehicle, Resolution] = {}
        self._admission = admission
        self._slots = slots
        self._ways = ways
        self._claim = claim
        self._by_slot: dict[int, list[Resolution]] = {}
        self._awaiting: dict[Resolution, None] = {}

    def reset(self) -> None:
        """Forget which ones wait for a door."""
        self._awaiting.clear()

    def need(self, slot: int) -> bool:
        """Return whether one needs a slot."""
        return slot in self._by_slot

    def against(self, robot: Vehicle, slots: Iterable[int], first: Vehicle) -> Resolution | None:
        """Return a resolution that keeps a vehicle out of some slots, into which it is to go for the *first* one."""
        if not self._by_slot:
            return None
        order, by_slot, near = first.rank, self._by_slot, self._slots.near
        for slot in slots:
            for at in (slot, *near.get(slot, ())) if near else (slot,):
                for resolution in by_slot.get(at, ()):
                    if robot not in resolution.robots and resolution.first.rank < order:
                        return resolution
        return None

    def against_leg(self, robot: Vehicle, leg: Leg) -> Resolution | None:
        """Return the resolution that needs what a vehicle wants for itself, if any."""
        return self.against(robot, self._slots.of(leg), robot) if self._by_slot else None

    def see_to(self, robot: Vehicle) -> bool:
        """Return whether a vehicle that waits need only wait for a resolution to go on."""
        wait = self._admission.waits.get(robot)
        return robot in self.by_robot or (wait is not None and self.against_leg(robot, wait.leg) is not None)

    def begin(self, first: Vehicle, steps: list[Step]) -> None:
        """Make vehicles move in steps so that the *first* one can go on."""
        resolution = Resolution(first, steps)
        self.by_robot.update(dict.fromkeys(resolution.robots, resolution))
        for slot in _needed(steps):
            self._by_slot.setdefault(slot, []).append(resolution)
        self._go_on(resolution)

    def stands(self, robot: Vehicle) -> None:
        """Go on if a vehicle has come to where it is to move from."""
        resolution = self.by_robot.get(robot)
        if resolution is not None and robot not in resolution.moving:
            self._go_on_soon(resolution)

    def stays_aside(self, robot: Vehicle) -> bool:
        """Return whether a vehicle has yielded as a part of one; the next step begins, or all ask again."""
        resolution = self.by_robot.get(robot)
        if resolution is None:
            return False
        resolution.moving.pop(robot, None)
        self._go_on(resolution)
        return True

    def halted(self, robot: Vehicle) -> None:
        """Give up the one of which a vehicle is a part that was stopped: the next move would wait for it."""
        if robot in self.by_robot:
            self._drop(self.by_robot[robot])

    def opened(self) -> None:
        """Go on with moves that waited for a door or a lift."""
        awaiting, self._awaiting = self._awaiting, {}
        for resolution in awaiting:
            if self._is_active(resolution):
                self._go_on_soon(resolution)

    def _is_active(self, resolution: Resolution) -> bool:
        return self.by_robot.get(resolution.first) is resolution

    def _go_on_soon(self, resolution: Resolution) -> None:
        self._admission.soon(lambda: self._go_on(resolution) if self._is_active(resolution) else None)

    def _go_on(self, resolution: Resolution) -> None:
        """Begin the steps that are possible now; when none is left, or another vehicle is in the way, all ask again."""
        began, waits = True, False
        while began:
            # Where vehicles leave, the next ones may come.
            began, waits = False, False
            for step in resolution.ready(self._slots.near):
                if not all(map(self._may_still_move, step)) or self._is_claimed(step, resolution.first):
                    self._drop(resolution)
                    return
                if not self._may_begin(step, resolution):
                    waits = True
                elif self._slots.exchange([(move.robot, move.way.slots) for move in step]):
                    began = True
                    resolution.begin(step)
                    self._free(resolution, [step])
                    for move in step:
                        self._admission.push(move.robot, move.way.legs, resolution.first)
        self._let_go(resolution)
        if not (resolution.moving or waits):
            self._drop(resolution)

    def _is_claimed(self, step: Step, first: Vehicle) -> bool:
        """Return whether a step leads to where a vehicle keeps others out that set out before the *first*."""
        return any(self._claim.excludes(move.robot, move.way.slots, first.rank) for move in step)

    def _may_begin(self, step: Step, resolution: Resolution) -> bool:
        """Return whether a step need not wait for its vehicles, at work or on their way to it, nor for a door."""
        if not all(move.robot.may_yield for move in step):
            return False
        # Each is asked, so that each begins to open.
        let = [self._admission.lets(move.robot, move.way.legs) for move in step]
        if not all(let):
            self._awaiting[resolution] = None
        return all(let)

    def _may_still_move(self, move: Move) -> bool:
        """Return whether a vehicle is, or comes to, where it is to move from, and nothing is in its way for good."""
        if not move.robot.will_yield or self._slots.held(move.robot)[-1:] != (move.start,):
            return False
        return self._ways.is_open(move.robot, move.way)

    def _let_go(self, resolution: Resolution) -> None:
        """Make vehicles that were held back request again."""
        held_back = [*resolution.held_back]
        resolution.held_back.clear()
        self._admission.look_again(held_back)

    def _free(self, resolution: Resolution, steps: Iterable[Step]) -> None:
        """Let others enter what some steps of a resolution need no longer."""
        for slot in _needed(steps):
            there = self._by_slot[slot]
            there.remove(resolution)
            if not there:
                del self._by_slot[slot]

    def _drop(self, resolution: Resolution) -> None:
        self._free(resolution, resolution.steps)
        resolution.steps.clear()
        for robot in resolution.robots:
            self.by_robot.pop(robot, None)
        for robot in sorted(resolution.robots, key=by_rank):
            self._admission.try_again(robot)
        self._let_go(resolution)


def _needed(steps: Iterable[Step]) -> Iterator[int]:
    return (slot for step in steps for move in step for slot in move.way.slots)


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
