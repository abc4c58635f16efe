"""The ways: the moves that a vehicle can make from the place where it stands, and their costs.

A vehicle can stand at a waypoint, in the middle of a lane, or at a spot, which is a point beside the lanes.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

from hmrsim.caches import LruCache, Memo, exact
from hmrsim.errors import NoRoute
from hmrsim.geometry import SAME_PLACE, distance
from hmrsim.navigation.route import Leg

if TYPE_CHECKING:
    from hmrsim.geometry import Point
    from hmrsim.navigation.graph import Lane
    from hmrsim.navigation.lanes import Edge, Foot, Lanes
    from hmrsim.traffic.admission import Admission
    from hmrsim.traffic.policies._reservations import Slots
    from hmrsim.traffic.rules import Vehicle

    _Legs = list[tuple[int, tuple[Leg, ...]]]
    """Pairs of a waypoint and the legs that lead to it, or from it."""


_KEPT_POINTS = 1_024
"""The number of points beside the lanes whose ways are cached."""


class Way(NamedTuple):
    """A move from one place where a vehicle can stand to the next: along a lane, to or from a spot, or both.

    Attributes:
        legs: One or two legs; the first needs the slots of both, so that the vehicle does not stop in between.
        slots: The slots that the vehicle needs before it sets out.
        end: The slot where the vehicle stands afterwards: a waypoint, a spot, or the lane in whose middle it stops.
        number: The number of the lane if the way is a whole lane in one direction; -1 otherwise.
    """

    legs: tuple[Leg, ...]
    slots: tuple[int, ...]
    end: int
    number: int = -1

    @property
    def length(self) -> float:
        """The length, in the world's unit."""
        return sum(leg.length for leg in self.legs)


class Ways:
    """Finds the ways of one world.

    Args:
        admission: Knows the lanes of the world, and which of them are open.
        slots: Know the places of the vehicles.
    """

    def __init__(self, admission: Admission, slots: Slots) -> None:
        self._admission = admission
        self._lanes: Lanes = admission.graph.lanes
        self._slots = slots
        self._from_waypoint: dict[int, list[Way]] = self._lanes.derived(Ways.from_waypoint, dict)
        self._from_point: LruCache[Point, list[Way]] = LruCache(_KEPT_POINTS)
        self._to_point: LruCache[tuple[int, Point], list[tuple[int, Way]]] = LruCache(_KEPT_POINTS)
        # Legs depend only on the map, but the slots of spots differ from run to run.
        self._legs: LruCache[tuple[bytes, bool], _Legs] = self._lanes.derived(_joints, lambda: LruCache(_KEPT_POINTS))

    def leaving(self, robot: Vehicle) -> list[Way]:
        """Return the open ways from the place where a vehicle stands."""
        held = self._slots.held(robot)
        if not held:
            return []
        place = held[-1]
        found = self.from_waypoint(place) if place < len(self._lanes.names) else self._at(place, robot.pose().point)
        return self.open(robot, found)

    def open(self, robot: Vehicle, ways: list[Way]) -> list[Way]:
        """Return the ways along which a vehicle can be moved: those without a lane that is closed to it."""
        shut = self._admission.shut_to(robot)
        return [way for way in ways if not (way.legs[0].lane in shut or way.legs[-1].lane in shut)] if shut else ways

    def is_open(self, robot: Vehicle, way: Way) -> bool:
        """Return whether a vehicle can be moved along a way."""
        return bool(self.open(robot, [way]))

    def _at(self, place: int, point: Point) -> list[Way]:
        """Return the ways from a lane or a spot, where a vehicle stands at a point."""
        if self._slots.is_lane(place):
            return self._along(place, point)
        return self.from_spot(place)

    def from_waypoint(self, node: int) -> list[Way]:
        """Return the lanes that begin at a waypoint."""
        known = self._from_waypoint.get(node)
        if known is None:
            known = [Way((edge.leg,), edge.leg.slots, edge.end, edge.number) for edge in self._lanes.out[node]]
            self._from_waypoint[node] = known
        return known

    def _along(self, lane: int, point: Point) -> list[Way]:
        """Return the ways from the middle of a lane to its ends."""
        edges = self._lanes.leading_to(lane)
        parts = [(edge, self._lanes.part(edge, point, edge.leg.end)) for edge in edges]
        return [Way((part,), part.slots, edge.end) for edge, part in parts if part.length > 0.0]

    def from_spot(self, spot: int) -> list[Way]:
        """Return the ways from a spot to the ends of the nearest lane with a clear line of sight to it."""
        point = self._slots.points[spot]
        return self._from_point.get(point, lambda: self._leaving_point(point))

    def _leaving_point(self, point: Point) -> list[Way]:
        legs_from = self._legs.get((exact(*point), False), lambda: _legs_from(self._lanes, point))
        return [Way(legs, self._slots.of(legs[0]), end) for end, legs in legs_from]

    def to_spot(self, spot: int) -> list[tuple[int, Way]]:
        """Return the waypoints from which a vehicle reaches a spot, and the way from each."""
        point = self._slots.points[spot]
        return self._to_point.get((spot, point), lambda: self._reaching(spot, point))

    def _reaching(self, spot: int, point: Point) -> list[tuple[int, Way]]:
        legs_to = self._legs.get((exact(*point), True), lambda: _legs_to(self._lanes, point))
        return [(start, Way(legs, self._slots.of(legs[0]), spot)) for start, legs in legs_to]

    def to_places(self, node: int) -> list[Way]:
        """Return the ways from a waypoint to the places of the world that are beside the lanes."""
        if node not in self._places:
            return []
        spots = [self._slots.spot(point) for point in self._places[node]]
        return [way for spot in spots for start, way in self.to_spot(spot) if start == node]

    @cached_property
    def _places(self) -> dict[int, list[Point]]:
        """The places beside the lanes, by the waypoints from which they are reached."""
        found: dict[int, list[Point]] = {}
        for place in self._admission.world.places.values():
            if not self._lanes.approaches(place.at)[0]:
                for node, _ in self.to_spot(self._slots.spot(place.at)):
                    found.setdefault(node, []).append(place.at)
        return found

    def to_lane(self, lane: int, point: Point) -> Iterator[tuple[int, Way]]:
        """Yield the ends of a lane from which a vehicle can reach a point of the lane, and the way from each."""
        for edge in self._lanes.leading_to(lane):
            part = self._lanes.part(edge, edge.leg.start, point)
            yield edge.start, Way((part,), self._slots.of(part), lane)


class Costs:
    """The costs of ways for vehicles on their trips, in seconds."""

    def __init__(self, admission: Admission) -> None:
        self._admission = admission
        self._limited = admission.graph.lanes.limited
        self._to_goals: dict[Vehicle, tuple[Point, float, frozenset[Lane], Collection[Lane], Sequence[float]]] = {}
        # A world has few different speeds.
        self._by_way = Memo(admission.graph.seconds)

    def of(self, robot: Vehicle) -> tuple[Sequence[float] | None, Sequence[float], float]:
        """Return the costs of a vehicle from each waypoint to its goal, the costs of ways by number, and its speed.

        The first is None for a vehicle without a goal. The speed is 1 without lifts and speed limits of lanes, since
        it does not decide then which route is the quickest, and all vehicles can share one table.
        """
        speed = robot.speed if self._limited else 1.0
        return self._to_goal(robot, speed), self._by_way[speed], speed

    def forget(self, robot: Vehicle) -> None:
        """Forget a vehicle that has left the world."""
        self._to_goals.pop(robot, None)

    def reset(self) -> None:
        """Forget the travel times of all vehicles' goals."""
        self._to_goals.clear()

    def _to_goal(self, robot: Vehicle, speed: float) -> Sequence[float] | None:
        goal = robot.goal
        if goal is None:
            return None
        graph, known = self._admission.graph, self._to_goals.get(robot)
        kept_off = self._admission.kept_off(robot)
        if known and known[0] is goal and known[1] == speed and known[2] is graph.closed and known[3] == kept_off:
            return known[4]
        try:
            costs = graph.seconds_to(goal, speed, kept_off)
        except NoRoute:
            return None
        self._to_goals[robot] = goal, speed, graph.closed, kept_off, costs
        return costs


def _legs_from(lanes: Lanes, point: Point) -> _Legs:
    """Return the waypoints that a vehicle can reach from a point beside the lanes, and the legs to each."""
    found: dict[int, tuple[Leg, ...]] = {}
    for edge, foot in _joints(lanes, point):
        node = _waypoint_at(lanes, edge, foot)
        if node is not None:
            found.setdefault(node, (Leg(point, lanes.points[node], foot.away, slots=(node,)),))
        elif edge.end not in found:
            part = lanes.part(edge, foot.at, edge.leg.end)
            found[edge.end] = lanes.route([Leg(point, foot.at, foot.away), part]).legs
    return [*found.items()]


def _legs_to(lanes: Lanes, point: Point) -> _Legs:
    """Return the waypoints from which a vehicle can reach a point beside the lanes, and the legs from each."""
    found: dict[int, tuple[Leg, ...]] = {}
    for edge, foot in _joints(lanes, point):
        node = _waypoint_at(lanes, edge, foot)
        start = edge.start if node is None else node
        if start in found:
            continue
        if node is not None:
            found[start] = (Leg(lanes.points[node], point, foot.away),)
        else:
            part = lanes.part(edge, edge.leg.start, foot.at)
            found[start] = lanes.route([part, Leg(foot.at, point, foot.away)]).legs
    return [*found.items()]


def _joints(lanes: Lanes, point: Point) -> Iterator[tuple[Edge, Foot]]:
    for foot in next(lanes.joints(point), ()):
        yield lanes.edges[foot.number], foot


def _waypoint_at(lanes: Lanes, edge: Edge, foot: Foot) -> int | None:
    """Return the waypoint at a point of a lane, which may belong to another lane; None if there is no waypoint."""
    nodes = dict.fromkeys([lanes.at.get(foot.at, edge.start), edge.start, edge.end])
    return next((node for node in nodes if distance(lanes.points[node], foot.at) <= SAME_PLACE), None)
