"""Claims: slots that a vehicle which has waited for long reserves, so that others do not slip in before it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hmrsim.traffic.policies._reservations import Slots
    from hmrsim.traffic.policies._vehicle import Vehicle

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
