"""Resolutions of deadlocks: steps in which vehicles move, and the places that are kept free for them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

from hmrsim.traffic.policies.reserve import rank

if TYPE_CHECKING:
    from hmrsim.navigation.lanes import Edge
    from hmrsim.traffic.policies._nearness import Near
    from hmrsim.traffic.policies._vehicle import Vehicle


class Move(NamedTuple):
    """One vehicle drives one lane."""

    robot: Vehicle
    edge: Edge


Step = Sequence[Move]
"""One move, or those of a circle of vehicles that move on all at once."""


@dataclass(eq=False)
class Resolution:
    """A deadlock that is being resolved.

    Attributes:
        first: The vehicle for which the others move.
        steps: The steps that are left, in order.
        moving: How many vehicles are still on their way in the step before those.
        robots: All vehicles that move, the first one first.
        held_back: Other vehicles that wait for what the steps that are left need.
    """

    first: Vehicle
    steps: list[Step]
    moving: int = field(init=False, default=0)
    robots: list[Vehicle] = field(init=False)
    held_back: dict[Vehicle, None] = field(init=False, default_factory=dict)

    def __post_init__(self) -> None:
        """Note the vehicles that move."""
        self.robots = [*dict.fromkeys([self.first, *(move.robot for step in self.steps for move in step)])]

    def begin_step(self) -> None:
        """Take note that the vehicles of the next step set out."""
        self.moving = len(self.steps.pop(0))

    def arrive(self) -> bool:
        """Take note that a vehicle of the step has arrived; return whether it was the last one."""
        self.moving -= 1
        return self.moving <= 0


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

    def _needed(self, steps: Iterable[Step]) -> Iterator[int]:
        for step in steps:
            for move in step:
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
