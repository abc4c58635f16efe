"""A group of vehicles that may be moved in a search: the ways of each, and the vehicles in the way."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

from hmrsim.caches import Memo
from hmrsim.traffic.nearness import touch

if TYPE_CHECKING:
    from hmrsim.traffic.admission import Admission
    from hmrsim.traffic.policies._reservations import Slots
    from hmrsim.traffic.policies._resolution import Resolutions
    from hmrsim.traffic.policies._ways import Way, Ways
    from hmrsim.traffic.rules import Vehicle

_NONE: Final = frozenset["Vehicle"]()

Places = tuple[int, ...]
"""The place of each vehicle of a group, by its number in the group: a waypoint, a spot or a lane."""


class Group:
    """The vehicles that a search moves; all others stay where they are.

    Args:
        slots: Know the places of all vehicles.
        ways: Find the ways from these places.
        resolutions: The resolutions in progress, which need slots; None to ignore them.
        first: The blocked vehicle for which the others move.
        target: The slot that the blocked vehicle has to reach.

    Attributes:
        robots: The vehicles, beginning with the blocked one.
        target: The slot that the blocked vehicle has to reach.
        start: The places of the vehicles before any move.
    """

    def __init__(
        self,
        admission: Admission,
        slots: Slots,
        ways: Ways,
        resolutions: Resolutions | None,
        first: Vehicle,
        target: int,
    ) -> None:
        self.robots: list[Vehicle] = []
        self.target = target
        self.start: Places = ()
        # The lanes in whose middle a vehicle stands at the start, or in which the target is.
        self._middles = {target} if slots.is_lane(target) else set()
        self._admission = admission
        self._slots = slots
        self._resolutions = resolutions
        self._members: set[Vehicle] = set()
        self._finder = ways
        self._kind_numbers: dict[object, int] = {}
        self._kinds: list[int] = []
        self._occupied: dict[tuple[int, int], tuple[int, ...]] = {}
        # All open ways with the vehicles in the way, and those ways on which only members of the group are in the way.
        self._found: dict[tuple[int, int], list[tuple[Way, frozenset[Vehicle]]]] = {}
        self._ways: dict[tuple[int, int], list[Way]] = {}
        self._rooms = Memo[int, float](lambda slot: slots.room(slot, self.robots))
        self._near = Memo(self._slots_near)
        self._hits = Memo(self._slots_hit)
        self.add(first)
        self._into = self._ways_to_target()

    def add(self, robot: Vehicle) -> None:
        """Add a vehicle to the group."""
        held, kind = self._slots.held(robot), (robot.radius, *self._admission.kept_off(robot))
        place = held[-1]
        if len(held) > 1 and (robot.stands or robot.waits):
            self._occupied[len(self.robots), place] = held
        if self._slots.is_lane(place):
            self._middles.add(place)
        self._kinds.append(self._kind_numbers.setdefault(kind, len(self._kind_numbers)))
        self.robots.append(robot)
        self.start = (*self.start, place)
        self._members.add(robot)
        self._ways.clear()
        self._rooms.clear()

    def gains_ways_from(self, robot: Vehicle) -> bool:
        """Return whether the group can use a way only because this member may be moved."""
        members = self._members
        return any(robot in others and others <= members for found in self._found.values() for _, others in found)

    def _ways_to_target(self) -> dict[int, list[Way]]:
        """Return the ways from waypoints to the target, if that is a spot or in the middle of a lane."""
        found: dict[int, list[Way]] = {}
        if self.target in self._slots.points:
            into = self._finder.to_spot(self.target)
        elif self._slots.is_lane(self.target) and (leg := self.robots[0].next_leg):
            self._occupied[0, self.target] = self._slots.of(leg)
            into = [*self._finder.to_lane(self.target, leg.end)]
        else:
            into = []
        for node, way in into:
            found.setdefault(node, []).append(way)
        return found

    def key(self, places: Places) -> object:
        """Return a key that is equal for combinations of places which differ only in interchangeable vehicles."""
        return places[0], tuple(sorted(zip(places[1:], self._kinds[1:], strict=True)))

    def is_spot(self, place: int) -> bool:
        """Return whether a place is a spot, which is beside the lanes."""
        return place in self._slots.points

    def occupied(self, i: int, place: int) -> tuple[int, ...]:
        """Return the slots that a vehicle holds at a place."""
        return self._occupied.get((i, place)) or (place,)

    def ways(self, i: int, places: Places) -> list[Way]:
        """Return the ways of a vehicle from its place on which only other members of the group are in the way."""
        place = places[i]
        # A vehicle in the middle of a lane has individual ways; elsewhere all vehicles of its kind share them.
        key = (-1 - i if place in self._middles else self._kinds[i] if i else -1, place)
        if key not in self._ways:
            if key not in self._found:
                self._found[key] = self._find_ways(i, place)
            members = self._members
            self._ways[key] = [way for way, others in self._found[key] if others <= members]
        return self._ways[key]

    def _find_ways(self, i: int, place: int) -> list[tuple[Way, frozenset[Vehicle]]]:
        """Return the open ways of a vehicle from a place, each with the vehicles that are in the way."""
        robot = self.robots[i]
        if place == self.start[i] and place in self._middles:
            found = self._finder.leaving(robot)
        elif place in self._slots.points:
            found = self._finder.from_spot(place)
        elif place in self._middles:
            return []
        else:
            into = self._into.get(place, ())
            beside = [way for way in self._finder.to_places(place) if way.end != self.target]
            found = [*self._finder.from_waypoint(place), *beside, *into]
        ways = [way for way in self._finder.open(robot, found) if not (i and way.end in self._middles)]
        if self._resolutions is not None and self._resolutions.by_robot:
            ways = [way for way in ways if self._resolutions.against(robot, way.slots, self.robots[0]) is None]
        return [(way, self._others_on(robot, way)) for way in ways]

    def _others_on(self, robot: Vehicle, way: Way) -> frozenset[Vehicle]:
        """Return the vehicles that are in the way of a vehicle now."""
        slots, free, near = self._slots, self._slots.free, self._slots.near
        # Most slots are free, and near no other.
        taken = [slot for slot in way.slots if free[slot] < 1 or slot in near]
        return frozenset([other for slot in taken for other in slots.in_the_way(robot, slot)]) if taken else _NONE

    def in_the_way(self, i: int, way: Way, places: Places) -> list[int]:
        """Return the numbers of the members because of which another one can't drive a way."""
        hits = self._hits[way.slots]
        found: list[int] = []
        for j, place in enumerate(places):
            if j == i:
                continue
            if place in hits:
                # Most slots have room for one.
                if (hits[place] < 0.0 and self._rooms[place] <= 1) or self._stops(hits[place], place, i, j, places):
                    found.append(j)
            elif (j, place) in self._occupied and any(
                at in hits and self._stops(hits[at], at, i, j, places) for at in self._occupied[j, place]
            ):
                found.append(j)
        return found

    def _stops(self, away: float, slot: int, i: int, j: int, places: Places) -> bool:
        """Return whether a vehicle in a slot so far away stops another one, which needs that slot if it is negative."""
        if away < 0.0:
            return self._is_full(slot, i, places)
        return self._touch(away, i, j, places)

    def _slots_hit(self, wanted: tuple[int, ...]) -> dict[int, float]:
        """Return the slots that a way needs or is near to, with their distances; -1 for those that it needs."""
        return {**self._near[wanted], **dict.fromkeys(wanted, -1.0)}

    def fit(self, drives: Sequence[tuple[int, Way]]) -> bool:
        """Return whether vehicles that drive at the same time have room, and do not touch each other."""
        for n, (i, way) in enumerate(drives):
            near = self._near[way.slots]
            for j, other in drives[:n]:
                if any(slot in way.slots and self._rooms[slot] <= 1 for slot in other.slots):
                    return False
                radii = self.robots[i].radius + self.robots[j].radius
                if any(slot in near and touch(near[slot], radii) for slot in other.slots):
                    return False
        return True

    def blocks(self, j: int, place: int, i: int, way: Way) -> bool:
        """Return whether a member at a place would block another one's way, ignoring the rest of the group."""
        near = self._near[way.slots]
        for slot in self.occupied(j, place):
            if slot in way.slots and self._rooms[slot] <= 1:
                return True
            if slot in near and touch(near[slot], self.robots[i].radius + self.robots[j].radius):
                return True
        return False

    def _is_full(self, slot: int, i: int, places: Places) -> bool:
        """Return whether the other members leave no room in a slot that one of them occupies."""
        room, occupied = self._rooms[slot], self._occupied
        if room <= 1:
            return True
        inside = 0
        for there in enumerate(places):
            if there[0] != i:
                inside += slot in occupied[there] if there in occupied else slot == there[1]
        return inside >= room

    def _slots_near(self, wanted: tuple[int, ...]) -> dict[int, float]:
        """Return the slots near those of a way, with their distances."""
        found: dict[int, float] = {}
        for slot in wanted:
            for at, away in self._slots.near[slot].items() if slot in self._slots.near else ():
                found[at] = min(away, found.get(at, away))
        return found

    def _touch(self, away: float, i: int, j: int, places: Places) -> bool:
        """Return whether two members would touch that do not touch already."""
        radii = self.robots[i].radius + self.robots[j].radius
        if not touch(away, radii):
            return False
        near = self._near[self.occupied(i, places[i])]
        return not any(touch(near[slot], radii) for slot in self.occupied(j, places[j]) if slot in near)
