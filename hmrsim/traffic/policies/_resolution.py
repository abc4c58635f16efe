"""Resolutions of deadlocks: steps in which vehicles move, and the slots that are reserved or claimed for these."""

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
    """A move of one vehicle along a way.

    Attributes:
        start: The slot where the vehicle stands before the move.
    """

    robot: Vehicle
    way: Way
    start: int


Step = Sequence[Move]
"""A single move, or the moves of vehicles in a circle, which move all at once."""


@dataclass(eq=False)
class Resolution:
    """A deadlock that is being resolved in steps.

    Independent steps are made at the same time: a step begins as soon as its vehicles have made their earlier moves,
    and no earlier step that is left needs one of its slots.

    Attributes:
        first: The vehicle for which the others move.
        steps: The steps that are left, in order.
        moving: The vehicles that are moving, with their ways.
        robots: All vehicles that move, the first one first.
        held_back: Other vehicles that wait for slots which the remaining steps need.
    """

    first: Vehicle
    steps: list[Step]
    moving: dict[Vehicle, Way] = field(init=False, default_factory=dict)
    robots: list[Vehicle] = field(init=False)
    held_back: dict[Vehicle, None] = field(init=False, default_factory=dict)

    def __post_init__(self) -> None:
        """Derive the vehicles from the steps."""
        self.robots = [*dict.fromkeys([self.first, *(move.robot for step in self.steps for move in step)])]

    def ready(self, near: Near) -> list[Step]:
        """Return the steps that can begin before the others that are left, in order."""
        busy, ready = {*self.moving}, list[Step]()
        taken = {slot for way in self.moving.values() for slot in way.slots}
        for step in self.steps:
            robots = {move.robot for move in step}
            needed = {slot for move in step for slot in (move.start, *move.way.slots)}
            around = {at for slot in needed for at in near.get(slot, ())}
            if busy.isdisjoint(robots) and taken.isdisjoint(needed) and taken.isdisjoint(around):
                ready.append(step)
            busy |= robots
            taken |= needed
        return ready

    def begin(self, step: Step) -> None:
        """Record that the vehicles of a step set out."""
        self.steps.remove(step)
        self.moving.update((move.robot, move.way) for move in step)


class Resolutions:
    """The deadlocks that are being resolved, with the slots that their remaining steps need.

    Vehicles that set out later don't enter these slots before the steps are made.

    Args:
        slots: Know the places of the vehicles.
        ways: Find the ways from these places.
        claim: Keeps vehicles out of the slots that a vehicle which set out earlier needs.

    Attributes:
        by_robot: The resolution of each vehicle that takes part in one. Read-only.
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
        """Forget which resolutions wait for a door or a lift."""
        self._awaiting.clear()

    def need(self, slot: int) -> bool:
        """Return whether any resolution needs a slot."""
        return slot in self._by_slot

    def against(self, robot: Vehicle, slots: Iterable[int], first: Vehicle) -> Resolution | None:
        """Return a resolution that keeps a vehicle, moved for the *first* one, out of some slots; None if none does."""
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
        """Return a resolution that keeps a vehicle out of the slots of a leg; None if none does."""
        return self.against(robot, self._slots.of(leg), robot) if self._by_slot else None

    def see_to(self, robot: Vehicle) -> bool:
        """Return whether a waiting vehicle has only to wait until a resolution moves it or ends."""
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
        """Continue the resolution of a vehicle that has reached the start of its next move."""
        resolution = self.by_robot.get(robot)
        if resolution is not None and robot not in resolution.moving:
            self._go_on_soon(resolution)

    def stays_aside(self, robot: Vehicle) -> bool:
        """Continue the resolution of a vehicle that has made a move; return False if it has none."""
        resolution = self.by_robot.get(robot)
        if resolution is None:
            return False
        resolution.moving.pop(robot, None)
        self._go_on(resolution)
        return True

    def halted(self, robot: Vehicle) -> None:
        """Give up the resolution of a vehicle that was stopped, since it would never continue."""
        if robot in self.by_robot:
            self._drop(self.by_robot[robot])

    def opened(self) -> None:
        """Continue the resolutions that waited for a door or a lift."""
        awaiting, self._awaiting = self._awaiting, {}
        for resolution in awaiting:
            if self._is_active(resolution):
                self._go_on_soon(resolution)

    def _is_active(self, resolution: Resolution) -> bool:
        return self.by_robot.get(resolution.first) is resolution

    def _go_on_soon(self, resolution: Resolution) -> None:
        self._admission.soon(lambda: self._go_on(resolution) if self._is_active(resolution) else None)

    def _go_on(self, resolution: Resolution) -> None:
        """Begin the steps that are possible now; drop the resolution if it is complete or can't continue."""
        began, waits = True, False
        while began:
            # The slots that vehicles leave may be those that the next step needs.
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
        """Return whether a vehicle that set out before *first* keeps others out of the slots of a step."""
        return any(self._claim.excludes(move.robot, move.way.slots, first.rank) for move in step)

    def _may_begin(self, step: Step, resolution: Resolution) -> bool:
        """Return whether all vehicles of a step can move now, and no door or lift has to open first."""
        if not all(move.robot.may_yield for move in step):
            return False
        # No short circuit: every door and lift on the ways has to begin to open.
        let = [self._admission.lets(move.robot, move.way.legs) for move in step]
        if not all(let):
            self._awaiting[resolution] = None
        return all(let)

    def _may_still_move(self, move: Move) -> bool:
        """Return whether a vehicle is at the start of a move, or will be, and nothing blocks it for good."""
        if not move.robot.will_yield or self._slots.held(move.robot)[-1:] != (move.start,):
            return False
        return self._ways.is_open(move.robot, move.way)

    def _let_go(self, resolution: Resolution) -> None:
        """Make vehicles that were held back request again."""
        held_back = [*resolution.held_back]
        resolution.held_back.clear()
        self._admission.look_again(held_back)

    def _free(self, resolution: Resolution, steps: Iterable[Step]) -> None:
        """Release the slots of some steps, so that other vehicles may enter them."""
        for slot in _needed(steps):
            resolutions = self._by_slot[slot]
            resolutions.remove(resolution)
            if not resolutions:
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
"""Simulated seconds of waiting after which the vehicle that set out first claims the slots that it needs."""


class Claim:
    """The slots that one vehicle at a time claims, so that vehicles that set out later don't enter them.

    Args:
        slots: The slots of the world.
        released: Called at the end of the claim with the vehicles that were kept out.

    Attributes:
        holder: The vehicle that claims slots; None if there is none.
    """

    def __init__(self, slots: Slots, released: Callable[[Sequence[Vehicle]], None]) -> None:
        self.holder: Vehicle | None = None
        self._slots = slots
        self._released = released
        self._claimed: dict[int, None] = {}
        self._kept_out: dict[Vehicle, None] = {}

    def extend(self, robot: Vehicle, slots: Iterable[int]) -> None:
        """Claim further slots for a vehicle; this ends the claim of any other vehicle."""
        if robot is not self.holder:
            self.end()
            self.holder = robot
        self._claimed.update(dict.fromkeys(slots))

    def end(self) -> None:
        """End the claim, and release the vehicles that were kept out."""
        self.holder = None
        self._claimed.clear()
        kept_out, self._kept_out = self._kept_out, {}
        if kept_out:
            self._released([*kept_out])

    def excludes(self, robot: Vehicle, slots: Iterable[int], order: tuple[float, str]) -> bool:
        """Return whether the claim keeps a vehicle out of slots that it enters for a vehicle of this rank."""
        first = self.holder
        if first is None or robot is first or order <= first.rank:
            return False
        held = self._slots.held(robot)
        return any(slot in self._claimed and slot not in held for slot in slots)

    def keeps_out(self, robot: Vehicle, slots: Iterable[int]) -> bool:
        """Return whether the claim keeps a vehicle out of slots; if so, it is released when the claim ends."""
        if not self.excludes(robot, slots, robot.rank):
            return False
        self._kept_out[robot] = None
        return True

    def forget(self, robot: Vehicle) -> None:
        """Forget a vehicle that has left the world."""
        self._kept_out.pop(robot, None)
