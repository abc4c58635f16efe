"""The places of a world where robots can stand and the moves between them, for a search over configurations.

The search judges the traffic policies, so it shares no code with them except the rule for when two footprints touch.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

from hmrsim.geometry import SAME_PLACE, Point, crosses, distance, foot, gap
from hmrsim.traffic.nearness import touch
from hmrsim.world.model import Waypoint

if TYPE_CHECKING:
    from hmrsim.world.model import World


class Place(NamedTuple):
    """A point where robots can stand.

    Attributes:
        at: The point.
        capacity: The number of robots that may be there at once.
        waypoint: The name of the waypoint at this point; empty if there is none.
        lane: The number of the lane on which the point lies between waypoints; -1 if there is none.
    """

    at: Point
    capacity: float = 1.0
    waypoint: str = ""
    lane: int = -1


@dataclass(frozen=True)
class Move:
    """A move from one place to another, by their numbers.

    Attributes:
        lane: The number of the lane of the move; -1 for a ride in a lift or a few meters off the lanes.
        doors: The robots for which all doors on the move open; None for all robots.
        path: The straight sections of the move.
        near: The places that may be too near to a robot on this move, each with its distance; 0 or less for places on
            the same lane.
    """

    start: int
    end: int
    lane: int
    doors: frozenset[str] | None = None
    path: tuple[tuple[Point, Point], ...] = ()
    near: tuple[tuple[int, float], ...] = field(default=(), compare=False)


class _Track(NamedTuple):
    """A lane with its directions of travel."""

    start: str
    end: str
    a: Point
    b: Point
    one_way: bool
    doors: frozenset[str] | None


class Places:
    """The places and moves of a world.

    Args:
        world: A world without errors.
        points: Points off the waypoints where robots have to stand: their initial positions and targets.

    Attributes:
        all: The places, waypoints first.
        moves: The moves that begin at each place.
        near: For each place, the other places where a robot may touch one here, each with its distance.
    """

    def __init__(self, world: World, points: list[Point]) -> None:
        self._world = world
        self._obstacles = world.obstacles(doors=True)
        self._widest = _widest_pair(world)
        self._tracks = [*self._find_tracks()]
        self.all = [Place(at, self._capacity(name), name) for name, at in world.points.items()]
        self._numbers = {place.at: number for number, place in enumerate(self.all)}
        self._by_name = {place.waypoint: number for number, place in enumerate(self.all)}
        for point in points:
            if self.number(point) is None:
                self._numbers[point] = len(self.all)
                self.all.append(Place(point, lane=self._lane_at(point)))
        self.near = [[*self._near(number)] for number in range(len(self.all))]
        self.moves: list[list[Move]] = [[] for _ in self.all]
        for move in self._find_moves():
            self.moves[move.start].append(self._with_near(move))

    def number(self, point: Point) -> int | None:
        """Return the number of the place at a point; None if there is no place."""
        number = self._numbers.get(point)
        if number is None:
            near = (number for number, place in enumerate(self.all) if distance(place.at, point) <= SAME_PLACE)
            number = next(near, None)
        return number

    @cached_property
    def rings(self) -> list[tuple[Move, ...]]:
        """The rings of three or more waypoints around which robots can move all at once, each as its moves."""
        return [*_rings(self.moves, [place.waypoint != "" for place in self.all])]

    def _capacity(self, name: str) -> float:
        world, waypoint = self._world, self._world.waypoints[name]
        if isinstance(waypoint, Waypoint) and waypoint.capacity:
            return waypoint.capacity
        if any(name in lift.stops for lift in world.lifts.values()):
            return math.inf
        default = (world.traffic.model_extra or {}).get("waypoint_capacity", 1)
        return math.inf if default is None else float(default)

    def _find_tracks(self) -> Iterator[_Track]:
        world = self._world
        for lane in world.lanes:
            a, b = world.points[lane.from_], world.points[lane.to]
            doors: frozenset[str] | None = None
            for door in world.doors.values():
                if door.opens_for is None or door.open or not crosses(a, b, *door.at):
                    continue
                names = (name for name, robot in world.robots.items() if {name, robot.type} & {*door.opens_for})
                doors = frozenset(names) & (frozenset(names) if doors is None else doors)
            yield _Track(lane.from_, lane.to, a, b, lane.one_way, doors)

    def _lane_at(self, point: Point) -> int:
        """Return the lane at a point, or -1 if there is none."""
        on = (i for i, lane in enumerate(self._tracks) if distance(point, foot(point, lane.a, lane.b)) <= SAME_PLACE)
        return next(on, -1)

    def _near(self, number: int) -> Iterator[tuple[int, float]]:
        """Yield the places close enough to one that two robots may touch."""
        for other in range(len(self.all)):
            if other != number and touch(away := self._distance(number, other), self._widest):
                yield other, away

    def _distance(self, number: int, other: int) -> float:
        """Return the distance between two places; one in the middle of a lane occupies the whole lane."""
        here, there = self.all[number], self.all[other]
        for one, two in ((here, there), (there, here)):
            if one.lane >= 0 and one.lane != two.lane:
                lane = self._tracks[one.lane]
                if two.waypoint in (lane.start, lane.end):
                    continue
                if two.lane < 0:
                    return distance(two.at, foot(two.at, lane.a, lane.b))
                two_lane = self._tracks[two.lane]
                if not {lane.start, lane.end} & {two_lane.start, two_lane.end}:
                    return gap(lane.a, lane.b, two_lane.a, two_lane.b)
        return 0.0 if here.lane == there.lane >= 0 else distance(here.at, there.at)

    def _find_moves(self) -> Iterator[Move]:
        yield from (Move(self._by_name[a], self._by_name[b], -1) for a, b, *_ in self._world.rides)
        stations: list[list[tuple[float, Point, int]]] = [
            [(0.0, lane.a, self._by_name[lane.start]), (distance(lane.a, lane.b), lane.b, self._by_name[lane.end])]
            for lane in self._tracks
        ]
        for number, place in enumerate(self.all):
            if place.waypoint:
                continue
            at, track = self._entrance(place)
            waypoint = self._numbers.get(at)
            if waypoint is not None and self.all[waypoint].waypoint:
                for start, end in ((waypoint, number), (number, waypoint)):
                    yield Move(start, end, -1, path=((at, place.at),))
            elif track >= 0:
                stations[track].append((distance(self._tracks[track].a, at), at, number))
        for track, lane in enumerate(self._tracks):
            for along, at, start in stations[track]:
                for to_along, to, end in stations[track]:
                    if start != end and (to_along >= along or not lane.one_way):
                        path = ((self.all[start].at, at), (at, to), (to, self.all[end].at))
                        yield Move(start, end, track, lane.doors, path)

    def _entrance(self, place: Place) -> tuple[Point, int]:
        """Return the nearest point on a lane that is visible from a place, and the lane, or -1 if none is visible."""
        if place.lane >= 0:
            return place.at, place.lane
        feet = sorted((distance(place.at, at), i, at) for i, at in enumerate(self._feet(place.at)))
        return next(((at, i) for _, i, at in feet if not self._obstacles.block(at, place.at)), (place.at, -1))

    def _feet(self, point: Point) -> Iterator[Point]:
        for lane in self._tracks:
            at = foot(point, lane.a, lane.b)
            # The waypoint itself, if the foot is that close to it.
            yield next((end for end in (lane.a, lane.b) if distance(at, end) <= SAME_PLACE), at)

    def _with_near(self, move: Move) -> Move:
        """Return a move with the places close to it."""
        ends = () if move.lane < 0 else (self._tracks[move.lane].start, self._tracks[move.lane].end)
        near: dict[int, float] = dict(self.near[move.end])
        for number, place in enumerate(self.all):
            if number in (move.start, move.end):
                near.pop(number, None)
                continue
            if place.lane == move.lane >= 0:
                near[number] = 0.0
            elif move.path and not (place.waypoint and place.waypoint in ends):
                away = min(gap(a, b, place.at, place.at) for a, b in move.path)
                away = min(away, self._between_lanes(move.lane, place.lane))
                if touch(away, self._widest):
                    near[number] = min(away, near.get(number, away))
        return Move(move.start, move.end, move.lane, move.doors, move.path, tuple(sorted(near.items())))

    def _between_lanes(self, lane: int, other: int) -> float:
        """Return the distance between two lanes; infinite if they share a waypoint, or if either is -1."""
        if lane < 0 or other < 0:
            return math.inf
        one, two = self._tracks[lane], self._tracks[other]
        return math.inf if {one.start, one.end} & {two.start, two.end} else gap(one.a, one.b, two.a, two.b)


def _widest_pair(world: World) -> float:
    """Return the sum of the two greatest radii of robots."""
    bases = (world.robot_type(robot).base for robot in world.robots.values())
    return math.fsum(sorted(base.radius or 0.0 for base in bases if not base.flies)[-2:])


_MAX_RINGS = 2_000
"""The maximum number of rings."""
_MAX_RING = 12
"""The maximum number of waypoints in a ring."""


def _rings(moves: list[list[Move]], waypoints: list[bool]) -> Iterator[tuple[Move, ...]]:
    """Yield simple rings of lanes between waypoints, each starting at its first waypoint in order."""
    count = 0
    for first in range(len(moves)):
        if not waypoints[first]:
            continue
        todo: list[tuple[Move, ...]] = [(move,) for move in moves[first] if move.end > first and waypoints[move.end]]
        while todo:
            path = todo.pop()
            for move in moves[path[-1].end]:
                if move.end == first and len(path) > 1:
                    count += 1
                    yield (*path, move)
                    if count >= _MAX_RINGS:
                        return
                elif (
                    move.end > first
                    and waypoints[move.end]
                    and len(path) < _MAX_RING
                    and all(move.end != before.end for before in path)
                ):
                    todo.append((*path, move))
