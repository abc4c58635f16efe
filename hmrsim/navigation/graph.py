"""The map of a world and the routes on it, given the lanes that are closed and the doors that are open now.

Worlds with the same map share it within a process, so that a run can use the routes planned in earlier ones. Nothing in
a `RoadMap` depends on a run: what a run changes, such as which doors are closed, is in its `WaypointGraph`.

Planning works on arrays (`hmrsim.navigation.adjacency`, `hmrsim.navigation.planner`) of the lanes that the graph for
networkx has, too (`World.graph`): searches that keep a tree for each destination are faster than networkx's, and need
none of its memory.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Final

from hmrsim.caches import LruCache
from hmrsim.errors import NoRoute
from hmrsim.geometry import SAME_PLACE, Obstacles, Point, between, distance
from hmrsim.interfaces.nav2_msgs import ComputePathToPose
from hmrsim.navigation.adjacency import Durations
from hmrsim.navigation.lanes import START, Lanes
from hmrsim.navigation.motion import Drives
from hmrsim.navigation.planner import Planner
from hmrsim.navigation.route import Leg, Route
from hmrsim.world.model import Derived, Door, World
from hmrsim.world.route_graph import route_ids

if TYPE_CHECKING:
    from array import array

    from hmrsim.world.route_graph import RouteIds


_KEPT_MAPS = 4
"""Cached road maps; the least recently used one is dropped."""

_MOST_WAYPOINTS = 20_000
"""Waypoints of the largest cached map: some 10 MB, and as much again for routes."""

_KEPT_DRIVES = 1_024
"""Cached motions per map."""

_KEPT_PIECES = 400_000
"""Pieces of all cached motions together, if each leads over the whole map: some 150 MB."""

_KEPT_STREETS = 4
"""Sets of avoided ways with cached planners: policies take them from the map and their settings."""


class RoadMap:
    """The lanes of a map, and planners on them.

    Args:
        world: A world with the map; its other parts are ignored.

    Attributes:
        lanes: The lanes.
        drives: The motions of robots on the lanes.
    """

    def __init__(self, world: World) -> None:
        self.lanes = Lanes(world)
        self.drives = Drives(min(_KEPT_DRIVES, _KEPT_PIECES // max(1, len(self.lanes.ways.ends))))
        self._planners: LruCache[tuple[tuple[int, ...], float], Planners] = LruCache(_KEPT_STREETS)

    def planners(self, avoided: Sequence[int] = (), factor: float = 1.0) -> Planners:
        """Return the planners in which some ways count for a multiple of their travel times."""
        key = (*avoided,), factor
        return self._planners.get(key, lambda: Planners(self.lanes, *key))


def road_map_of(world: World) -> RoadMap:
    """Return the road map of a world, which worlds with the same map share."""
    return _ROAD_MAPS(world) if len(world.waypoints) <= _MOST_WAYPOINTS else RoadMap(_bare(world))


def _bare(world: World) -> World:
    """Return a world that has only the map of another one, so that nothing else gets into the cache."""
    doors = {name: Door.model_construct(at=door.at) for name, door in world.doors.items()}
    return World.model_construct(
        bounds=world.bounds,
        waypoints=world.waypoints,
        lanes=world.lanes,
        walls=world.walls,
        doors=doors,
        lifts=world.lifts,
    )


def _cached(world: World) -> RoadMap:
    bare = _bare(world)
    # The text distinguishes equal numbers such as 0 and -0.
    return _BY_TEXT.get(bare.model_dump_json(exclude_unset=True), lambda: RoadMap(bare))


_BY_TEXT: Final[LruCache[str, RoadMap]] = LruCache(_KEPT_MAPS)
_ROAD_MAPS: Final = Derived(_cached, "bounds", "waypoints", "lanes", "walls", "doors", "lifts")


_KEPT_PLANNERS = 16
"""Cached planners, one for each set of closed lanes; the least recently used one is dropped."""

Lane = tuple[str, str]
"""A lane in one direction, by the waypoints where it begins and ends."""


class Planners:
    """Planners on the lanes of a map.

    Args:
        lanes: The lanes.
        avoided: The numbers of ways that count for longer.
        factor: How many times as long these count for.

    Attributes:
        durations: How long each way counts for.
    """

    def __init__(self, lanes: Lanes, avoided: Sequence[int] = (), factor: float = 1.0) -> None:
        self._lanes = lanes
        self.durations = Durations(lanes.ways, avoided, factor)
        self._kept: LruCache[frozenset[Lane], Planner] = LruCache(_KEPT_PLANNERS)

    def without(self, closed: frozenset[Lane]) -> Planner:
        """Return the planner that takes none of some lanes."""
        return self._kept.get(closed, lambda: self._planner(closed))

    def _planner(self, closed: frozenset[Lane]) -> Planner:
        numbers = self._lanes.numbers
        return Planner(self._lanes, self.durations, {numbers[lane] for lane in closed if lane in numbers})


class WaypointGraph:
    """The waypoints and lanes of one run, with the obstacles around them and the lanes that are closed.

    Args:
        world: Where they are. Its names must have been checked.

    Attributes:
        lanes: The properties of the lanes that no run changes.
        drives: How robots drive there.
        doors: The doors that are closed now.
    """

    def __init__(self, world: World) -> None:
        self._world = world
        self.waypoints = world.points
        self._road_map = road_map_of(world)
        self._planners = self._road_map.planners()
        self.lanes = self._road_map.lanes
        self.drives = self._road_map.drives
        self.doors = ClosedDoors()
        self._closed: frozenset[Lane] = frozenset()
        self._current: Planner | None = None

    @cached_property
    def ids(self) -> RouteIds:
        """The numbers of waypoints and lanes in Nav2's route graph."""
        return route_ids(self._world)

    @property
    def closed(self) -> frozenset[Lane]:
        """The closed lanes, which no robot may enter."""
        return self._closed

    @closed.setter
    def closed(self, lanes: frozenset[Lane]) -> None:
        self._closed = lanes
        self._current = None

    @property
    def _planner(self) -> Planner:
        """The planner without the closed lanes; created on use, since many lanes may close at one instant."""
        if self._current is None:
            self._current = self._planners.without(self._closed)
        return self._current

    def speed_limit(self, lane: Lane) -> float:
        """Return the speed limit of a lane; infinite without one."""
        return self.lanes.legs[self.lanes.numbers[lane]].speed_limit

    def avoid(self, ways: Sequence[int], factor: float) -> None:
        """Count ways in planning for a multiple of their travel times."""
        self._planners, self._current = self._road_map.planners(ways, factor), None

    def seconds(self, speed: float) -> array[float]:
        """Return the seconds that each way counts for a robot of this maximum speed, by number.

        Ways that are avoided count for longer.
        """
        return self._planners.durations.at(speed)

    def plan(self, start: Point, goal: Point, speed: float, avoid: Collection[Lane] = ()) -> Route:
        """Return the quickest route for a robot of this greatest *speed*, without the lanes that it is to *avoid*.

        A point off the lanes is reached by the point of each lane that is nearest to it of those from which a clear
        straight line leads there; the lane that gives the quickest trip is taken. Equal trips are ordered by the
        names of their waypoints. Turning and acceleration are not counted.

        Raises:
            NoRoute: The goal is outside the map (204), inside an obstacle (206), or no way leads there (208).
        """
        planner = self._planners.without(self._closed.union(avoid)) if avoid else self._planner
        route = planner.plan(start, goal, speed)
        if route is None:
            names = self._world.place_names
            message = f"no route from {names.of(start)} to {names.of(goal)}"
            raise NoRoute(ComputePathToPose.Result.NO_VALID_PATH, message)
        return route

    def detour(
        self, start: Point, goal: Point, speed: float, closed: Collection[Lane], avoid: Collection[Lane]
    ) -> Route:
        """Return the quickest route for one trip, without closed lanes and those to *avoid*.

        It is found faster than by `plan` where it begins at a waypoint, and nothing of it is kept.

        Raises:
            NoRoute: No way leads there (208).
        """
        if start not in self.lanes.at:
            return self.plan(start, goal, speed, [*closed, *avoid])
        planner = self._planners.without(self._closed.union(closed)) if closed else self._planner
        route = planner.detour(start, goal, speed, {*avoid})
        if route is None:
            raise NoRoute(ComputePathToPose.Result.NO_VALID_PATH, "no other route")
        return route

    def fly(self, start: Point, goal: Point) -> Route:
        """Return the straight way for a robot that flies, over all obstacles.

        Raises:
            NoRoute: The goal is outside the map (204), or inside an obstacle (206).
        """
        self.lanes.check(goal)
        return self.lanes.route([Leg(start, goal, distance(start, goal))], goal)

    def find_ways(self, goal: Point, speed: float) -> None:
        """Find the quickest ways to a destination from everywhere, so that to plan one takes no time.

        Raises:
            NoRoute: The goal is outside the map (204), or inside an obstacle (206).
        """
        self._planner.find_ways(goal, speed)

    def seconds_to(self, goal: Point, speed: float, avoid: Collection[Lane] = ()) -> Sequence[float]:
        """Return the seconds of the quickest route to a destination from each waypoint, by number; infinite for none.

        Raises:
            NoRoute: As `find_ways` says.
        """
        planner = self._planners.without(self._closed.union(avoid)) if avoid else self._planner
        return planner.seconds_to(goal, speed)

    def check_start(self, point: Point) -> None:
        """Check that a robot can set out from *point*.

        Raises:
            NoRoute: It is outside the map (203) or inside an obstacle (205).
        """
        self.lanes.check(point, START)
        if self.doors.obstacles.occupy(point):
            raise NoRoute(START.occupied, f"{START.noun} ({point[0]:g}, {point[1]:g}) is in a closed door")

    def clear_now(self, a: Point, b: Point) -> bool:
        """Return whether nothing stands on the straight line from *a* to *b* now: no wall, and no closed door."""
        return not (self.lanes.blocked(a, b) or self.doors.obstacles.block(a, b))

    def reach(self, a: Point, b: Point, *, flies: bool = False) -> tuple[Point, str]:
        """Return how far the straight line from *a* to *b* is free, and the obstacle there; an empty text for none.

        On a lane only closed doors do, and nothing on the ground stops a robot that *flies*.
        """
        on_map = self.lanes.share_on_map(a, b)
        free = 1.0 if flies else self.doors.obstacles.free(a, b)
        lane = self.lanes.edge_between(a, b)
        if not flies and (lane is None or lane.leg.ride):
            free = min(free, self.lanes.free(a, b))
        if min(on_map, free) >= 1.0:
            return b, ""
        x, y = end = between(a, b, min(on_map, free))
        return end, f"{'an obstacle' if free < on_map else 'the edge of the map'} at ({x:g}, {y:g})"

    def straight_through(self, points: Sequence[Point], *, flies: bool = False) -> tuple[Route, str]:
        """Return the straight legs between points up to the first obstacle, and that; an empty text for none.

        Between two points of one lane the lane is driven, which is open. A robot that *flies* goes straight over all.
        """
        legs: list[Leg] = []
        for a, b in pairwise(points):
            if distance(a, b) <= SAME_PLACE:
                continue
            if flies:
                blocked = self.reach(a, b, flies=True)[1]
                if blocked:
                    return self.lanes.route(legs), blocked
                legs.append(Leg(a, b, distance(a, b)))
                continue
            edge = self.lanes.edge_between(a, b)
            try:
                self.lanes.check(b)
            except NoRoute as wrong:
                if edge is None:
                    return self.lanes.route(legs), str(wrong)
            if edge is None and not self.clear_now(a, b):
                between = f"({a[0]:g}, {a[1]:g}) and ({b[0]:g}, {b[1]:g})"
                return self.lanes.route(legs), f"an obstacle stands between {between}"
            legs.append(self.lanes.part(edge, a, b) if edge else Leg(a, b, distance(a, b)))
        return self.lanes.route(legs), ""


class ClosedDoors:
    """The doors that are closed now, each identified by its jambs; each is a wall off the lanes."""

    def __init__(self) -> None:
        self._closed: dict[tuple[Point, Point], None] = {}
        self._made: Obstacles | None = None

    def set(self, at: tuple[Point, Point], *, is_open: bool) -> None:
        """Record that a door is open or closed now."""
        if is_open:
            self._closed.pop(at, None)
        else:
            self._closed[at] = None
        self._made = None

    @property
    def obstacles(self) -> Obstacles:
        """The closed doors as obstacles, computed on demand because many may close at one instant."""
        if self._made is None:
            self._made = Obstacles(self._closed, ())
        return self._made
