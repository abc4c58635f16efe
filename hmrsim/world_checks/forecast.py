"""A forecast of a world's traffic: where robots will block each other for good, or have no room to move.

It depends on the lanes, the traffic policy and the initial positions of robots, not on their goals.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

from hmrsim.diagnostics import Finding, listed, warning
from hmrsim.topology.bottlenecks import SingleTracks
from hmrsim.traffic.nearness import rooms_of_waypoints
from hmrsim.traffic.policies import settings_of
from hmrsim.traffic.policies.priority import PrioritySettings
from hmrsim.traffic.policies.reserve import ReserveSettings
from hmrsim.world.network import nearest
from hmrsim.world_checks.lanes import LaneIndex

if TYPE_CHECKING:
    from hmrsim.geometry import Point
    from hmrsim.world.model import World

_MAX_NAMED = 4
"""The number of waypoints of a corridor that a message names; of a longer corridor it names both ends."""

_MIN_ROBOTS = 2
"""The number of robots from which one can be in the way of another."""


def forecast(world: World) -> Iterator[Finding]:
    """Yield warnings about the traffic of a world under its policy; none under the policy `free`.

    The world must have no errors.
    """
    settings = settings_of(world)
    if isinstance(settings, ReserveSettings):
        checks = _Forecast(world, settings)
        yield from checks.check_corridors()
        yield from checks.check_docks()
        yield from checks.check_room()


class _Spot(NamedTuple):
    """A waypoint or a lane, as the location of a dock or a robot.

    Attributes:
        waypoints: The waypoint, or those at both ends of the lane.
        capacity: The number of robots that may be there at once.
    """

    waypoints: tuple[str, ...]
    capacity: float


class _Forecast:
    """The checks of a world under a policy with reservations.

    A part of the lanes is the set of waypoints that are connected with each other.
    """

    def __init__(self, world: World, settings: ReserveSettings) -> None:
        self._world = world
        self._settings = settings
        self._yields = isinstance(settings, PrioritySettings)
        self._rooms = rooms_of_waypoints(world, settings.waypoint_capacity)
        self._tracks = SingleTracks(world.graph, self._rooms)
        self._part = {name: part for part in self._tracks.parts for name in part}
        self._names = {world.points[name]: name for name in self._part}
        self._lanes = LaneIndex(world, world.lanes)
        ground = [name for name, robot in world.robots.items() if not world.robot_type(robot).base.flies]
        self._starts = {name: world.point(world.robots[name].at) for name in ground} if self._part else {}
        self._robots = Counter(self._part_at(self._starts))

    def _part_at(self, points: dict[str, Point]) -> list[frozenset[str]]:
        """Return the part of the lanes that is nearest to each point."""
        waypoints = {name: self._world.points[name] for name in self._part}
        return [self._part[name] for name in nearest(waypoints, points).values()] if points else []

    def _spot_at(self, point: Point) -> _Spot | None:
        """Return the waypoint or lane at a point; None if there is none."""
        if point in self._names:
            name = self._names[point]
            return _Spot((name,), self._rooms[name])
        for lane in map(self._world.lanes.__getitem__, self._lanes.lanes_at(point)):
            return _Spot((lane.from_, lane.to), lane.capacity or self._settings.lane_capacity or math.inf)
        return None

    def check_corridors(self) -> Iterator[Finding]:
        """Yield a warning for each single track in which two robots can block each other for good.

        Under the policy `priority`, one of them goes back, if the other can pass anywhere.
        """
        numbers = {frozenset((lane.from_, lane.to)): i for i, lane in enumerate(self._world.lanes)}
        for corridor in self._tracks.corridors:
            part = self._part[corridor[0]]
            is_all = len(corridor) == len(part)
            if self._robots[part] < _MIN_ROBOTS or (self._yields and not is_all):
                continue
            names = corridor if len(corridor) <= _MAX_NAMED else (corridor[0], "…", corridor[-1])
            remedy = "add a waypoint beside it" if is_all else "have one of them go back (policy 'priority')"
            yield warning(
                ("lanes", numbers[frozenset(corridor[:2])]),
                f"{' - '.join(names)} is a single track without a way around: two robots that meet in it block each"
                f" other for good, and lose their goals; make room for two at every other waypoint (capacity: 2), or"
                f" {remedy}",
                [*corridor],
            )

    def check_docks(self) -> Iterator[Finding]:
        """Yield a warning for each dock whose docked robots would block the only route to other waypoints."""
        for name, dock in self._world.docks.items():
            point = self._world.dock_point(name)
            spot = self._spot_at(point)
            beyond = self._tracks.cut_off(*spot.waypoints) if spot else ()
            if not spot or not beyond or spot.capacity > dock.capacity:
                continue
            if self._robots[self._part[spot.waypoints[0]]] >= _MIN_ROBOTS:
                yield warning(
                    ("docks", name, "at"),
                    f"is at {'-'.join(spot.waypoints)}, in the only way to {listed(sorted(beyond))}: no robot gets past"
                    f" one that is docked; move it aside, or make room for one more (capacity: {dock.capacity + 1})",
                    [*point],
                )

    def check_room(self) -> Iterator[Finding]:
        """Yield a warning for each part of the lanes that has too little room for its robots.

        Docks and places beside the lanes are additional room.
        """
        beside = self._room_beside()
        starts_on_lanes = {name: point for name, point in self._starts.items() if self._spot_at(point)}
        for part, robots in Counter(self._part_at(starts_on_lanes)).items():
            room, aside = self._tracks.room(part) + beside[part], self._tracks.room_aside(part) + beside[part]
            if robots >= max(room, _MIN_ROBOTS):
                reason = f"where {room:g} have room: none can move"
            elif robots >= _MIN_ROBOTS and robots > aside and not self._yields:
                reason = f"where {aside:g} can stand without being in the only way of others"
            else:
                continue
            text = (
                f"are {robots} on the lanes around {min(part)!r}, {reason}; add waypoints, or room at them (capacity)"
            )
            yield warning(("robots",), text, robots)

    def _room_beside(self) -> Counter[frozenset[str]]:
        """Return the number of robots that have room at the docks and places beside each part of the lanes."""
        world = self._world
        rooms = dict.fromkeys(world.places, 1) | {name: dock.capacity for name, dock in world.docks.items()}
        beside = {name: point for name in rooms if not self._spot_at(point := world.point(name))}
        totals: Counter[frozenset[str]] = Counter()
        for name, part in zip(beside, self._part_at(beside), strict=True):
            totals[part] += rooms[name]
        return totals
