"""Barriers on lanes, such as doors, and the vehicles that drive through them."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from hmrsim.navigation.graph import Lane
    from hmrsim.navigation.route import Leg
    from hmrsim.traffic.rules import Vehicle


class Barrier(Protocol):
    """A fixture on lanes that may have to open first, such as a door."""

    @property
    def lanes(self) -> Collection[Lane]:
        """The lanes that lead through it, in each direction in which they can be driven."""

    @property
    def refuses(self) -> bool:
        """Return whether the barrier may refuse a vehicle for good."""

    def may_pass(self, robot: Vehicle) -> bool:
        """Return whether it ever lets a vehicle pass; if not, routes avoid it."""

    def why_not(self, robot: Vehicle, leg: Leg) -> str:
        """Return why a vehicle can't begin a leg now, or ""; off the lanes the leg may be nowhere near.

        A barrier that opens for the vehicle begins to, and has vehicles look again when it is open.
        """

    def summon(self, leg: Leg) -> None:
        """Come for a vehicle that is to be moved along a leg, and does not wait for it."""

    def enter(self, robot: Vehicle, leg: Leg) -> None:
        """Record that a vehicle begins to drive through."""

    def leave(self, robot: Vehicle) -> None:
        """Record that a vehicle has driven through or has stopped on its leg."""


class Barriers:
    """The barriers of one world; each is asked on its lanes, and where a vehicle leaves the lanes, too.

    Attributes:
        on_lanes: Those on each lane that has any. To be read only, as it is for each lane that is driven.
        inside: Those through which vehicles drive now. To be read only, too.
    """

    def __init__(self) -> None:
        self._all: list[Barrier] = []
        self.on_lanes: dict[Lane, list[Barrier]] = {}
        # Most barriers are for every vehicle.
        self._refusing: dict[Lane, list[Barrier]] = {}
        self._kept_off: dict[Vehicle, dict[Lane, None]] = {}
        self.inside: dict[Vehicle, list[Barrier]] = {}

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self._all)

    def add(self, barrier: Barrier) -> None:
        """Add one, with its lanes."""
        self._all.append(barrier)
        for lane in barrier.lanes:
            self.on_lanes.setdefault(lane, []).append(barrier)
            if barrier.refuses:
                self._refusing.setdefault(lane, []).append(barrier)
        self._kept_off.clear()

    def changed(self, lanes: Iterable[Lane]) -> None:
        """Record that a barrier on these lanes has changed."""
        if self._kept_off and not self._refusing.keys().isdisjoint(lanes):
            self._kept_off.clear()

    def kept_off(self, robot: Vehicle) -> Collection[Lane]:
        """Return the lanes that a vehicle can never pass, in order."""
        if not self._refusing:
            return ()
        known = self._kept_off.get(robot)
        if known is None:
            lanes = [(lane, self._refusing[lane]) for lane in self.on_lanes if lane in self._refusing]
            known = {lane: None for lane, barriers in lanes if not all(each.may_pass(robot) for each in barriers)}
            self._kept_off[robot] = known
        return known

    def may_pass(self, robot: Vehicle, lane: Lane) -> bool:
        """Return whether a vehicle can ever pass a lane."""
        return lane not in self._refusing or lane not in self.kept_off(robot)

    def why_not(self, robot: Vehicle, leg: Leg) -> str:
        """Return why a vehicle can't begin a leg now, or ""; it does not join a lane to stop in the middle of it."""
        first, lane = "", leg.lane
        for barrier in self._all if lane is None else self.on_lanes.get(lane, ()):
            # Each is asked, so that each begins to open.
            why = barrier.why_not(robot, leg)
            first = first or why
        ahead = leg.joins
        if ahead is not None and ahead.lane and self.may_pass(robot, ahead.lane):
            why = self.why_not(robot, ahead)
            first = first or why
        return first

    def summon(self, leg: Leg) -> None:
        """Call the barriers on a leg for a vehicle that is going to drive it."""
        for barrier in self.on_lanes.get(leg.lane, ()) if leg.lane else ():
            barrier.summon(leg)

    def enter(self, robot: Vehicle, leg: Leg) -> None:
        """Record that a vehicle begins a leg, and has left the barriers of the one before."""
        if robot in self.inside:
            self.leave(robot)
        lane = leg.leads_onto
        if lane in self.on_lanes:
            barriers = self.inside[robot] = [*self.on_lanes[lane]]
            for barrier in barriers:
                barrier.enter(robot, leg)

    def leave(self, robot: Vehicle) -> None:
        """Record that a vehicle has reached the end of its leg or has stopped on it."""
        for barrier in self.inside.pop(robot, ()):
            barrier.leave(robot)
