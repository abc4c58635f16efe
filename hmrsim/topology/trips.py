"""Trips between places: their durations, which ones are impossible, and the share of them that uses each lane."""

from __future__ import annotations

import random
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import networkx as nx

from hmrsim.errors import NoRoute
from hmrsim.navigation.graph import WaypointGraph
from hmrsim.world.model import Base

if TYPE_CHECKING:
    from hmrsim.world.model import World


_MAX_SEARCH_STEPS: Final = 4_000_000
"""Maximum number of lanes to search for all destinations together, which takes some seconds."""
MAX_PLACES: Final = 100
SEED: Final = 1


@dataclass(frozen=True)
class Trip:
    """A trip, without the time for turning and acceleration.

    Attributes:
        start: The name of the place or dock where it begins.
        goal: The name of the place or dock where it ends.
        length: Its length, in the world's unit.
        seconds: Its duration.
    """

    start: str
    goal: str
    length: float
    seconds: float


@dataclass(frozen=True)
class Trips:
    """The quickest trips between places and docks.

    Attributes:
        found: All trips, in order of the names.
        failed: The pairs of places without a route, each with the reason.
        places: The number of places between which trips were planned.
        of: The number of all places; more than *places* if there are too many, of which a fixed sample is used.
        speed: The speed of the robots, in the world's unit per second.
    """

    found: tuple[Trip, ...]
    failed: dict[tuple[str, str], str]
    places: int
    of: int
    speed: float


def speeds_of(world: World) -> dict[float, tuple[str, ...]]:
    """Return the speeds of robots that drive, each with their types, the most frequent speed first.

    If no robot drives, the result is the default speed without types.
    """
    found: dict[float, list[str]] = {}
    for robot in world.robots.values():
        base = world.robot_type(robot).base
        if not base.flies:
            found.setdefault(world.speed(base), []).append(robot.type)
    ranked = sorted(found.items(), key=lambda one: (-len(one[1]), one[0]))
    return {speed: tuple(dict.fromkeys(types)) for speed, types in ranked} or {world.speed(Base()): ()}


def trips(world: World, speed: float) -> Trips:
    """Return the trips of robots of a maximum speed between all places and docks, or a sample of these trips."""
    names = sorted({*world.places, *world.docks})
    count = min(len(names), MAX_PLACES, _MAX_SEARCH_STEPS // max(1, len(world.ways)))
    chosen = names if count == len(names) else sorted(random.Random(SEED).sample(names, count))
    if count < 2:  # noqa: PLR2004
        return Trips((), {}, 0, len(names), speed)
    found, failed = [], {}
    graph = WaypointGraph(world)
    for goal in chosen:
        for start in chosen:
            if start != goal:
                try:
                    found.append(_trip(graph, world, (start, goal), speed))
                except NoRoute as error:
                    failed[start, goal] = str(error)
    return Trips(tuple(sorted(found, key=lambda trip: (trip.start, trip.goal))), failed, count, len(names), speed)


def seconds_at(world: World, trips: Iterable[Trip], speed: float) -> dict[tuple[str, str], float]:
    """Return the durations of trips at another speed, at which other routes may be quicker, by start and goal."""
    graph = WaypointGraph(world)
    ends = [(trip.start, trip.goal) for trip in trips]
    return {pair: _trip(graph, world, pair, speed).seconds for pair in ends}


def _trip(graph: WaypointGraph, world: World, ends: tuple[str, str], speed: float) -> Trip:
    start, goal = map(world.point, ends)
    graph.check_start(start)
    route = graph.plan(start, goal, speed)
    return Trip(*ends, route.length, sum(leg.seconds(speed) for leg in route.legs))


@dataclass(frozen=True)
class Reach:
    """The reachability of waypoints from each other.

    Attributes:
        strong: The number of waypoints in each part whose waypoints all reach each other, the largest first.
        gaps: The places and docks that can't be reached from each place or dock, in order of name.
        pairs: The number of such pairs of places and docks, a pair for each direction.
    """

    strong: tuple[int, ...]
    gaps: dict[str, tuple[str, ...]]
    pairs: int


def parts(graph: nx.DiGraph[str]) -> list[int]:
    """Return the number of waypoints in each part that lanes connect in any direction, the largest first.

    Closed lanes count: the parts are those of the map as it is drawn.
    """
    return sorted(map(len, nx.weakly_connected_components(graph)), reverse=True)


def reach(graph: nx.DiGraph[str]) -> Reach:
    """Return the waypoints that can be reached from each waypoint on lanes that are not closed.

    A place is reached if its waypoint is, so that places at one waypoint reach each other.
    """
    open_graph = _without_closed(graph)
    components = list(nx.strongly_connected_components(open_graph))
    strong = tuple(sorted(map(len, components), reverse=True))
    if len(components) < 2:  # noqa: PLR2004
        return Reach(strong, {}, 0)
    condensed = nx.condensation(open_graph, components)
    places: defaultdict[int, list[str]] = defaultdict(list)
    for waypoint in graph:
        places[condensed.graph["mapping"][waypoint]] += graph.nodes[waypoint]["places"]
    gaps: dict[str, tuple[str, ...]] = {}
    for number, names in places.items():
        if names:
            reached = {number, *nx.descendants(condensed, number)}
            missed = sorted(name for other, some in places.items() if other not in reached for name in some)
            gaps |= dict.fromkeys(names, tuple(missed)) if missed else {}
    return Reach(strong, dict(sorted(gaps.items())), sum(map(len, gaps.values())))


def _without_closed(graph: nx.DiGraph[str]) -> nx.DiGraph[str]:
    """Return the graph without its closed lanes, or the graph itself if it has none."""
    closed = [(start, end) for start, end, lane in graph.edges(data=True) if lane["closed"]]
    if not closed:
        return graph
    found = nx.DiGraph(graph)
    found.remove_edges_from(closed)
    return found


MAX_STEPS: Final = 2_000_000
"""Maximum number of lanes to search in all, which takes some seconds."""
MIN_STARTS: Final = 8
"""The least number of waypoints to start from; there is no result if there is no time for so many."""
MIN_PLACES: Final = 3
"""If fewer waypoints have places, trips lead from any waypoint to any other."""
_MICROSECONDS: Final = 1e6
_TAKES: Final = "takes"


@dataclass(frozen=True)
class Concentration:
    """The share of trips on each lane, with one trip from each start to each destination.

    Attributes:
        shares: The share of trips that use each lane or ride in any direction, the greatest first, by the names of the
            waypoints at its ends, in order. A trip is divided among equally quick routes.
        between: ``places`` (and docks), or ``waypoints`` if few of them have names.
        starts: The number of waypoints from which trips are counted.
        of: The number of all such waypoints; more than *starts* in a large graph, of which a fixed sample is used.
        speed: The speed of the robots, in the world's unit per second.
    """

    shares: dict[tuple[str, str], float]
    between: str
    starts: int
    of: int
    speed: float


def concentration(graph: nx.DiGraph[str], speed: float) -> Concentration | None:
    """Return where the traffic of robots with a maximum *speed* concentrates: edge betweenness, by travel time.

    Closed lanes are not used. The result is None if the graph is too large for `MAX_STEPS`.
    """
    named = [name for name, places in graph.nodes(data="places") if places]
    between = "places" if len(named) >= MIN_PLACES else "waypoints"
    ends = named if between == "places" else [name for name in graph if graph.degree(name)]
    count = min(len(ends), MAX_STEPS // max(1, graph.number_of_edges()))
    if count < min(MIN_STARTS, len(ends)):
        return None
    starts = ends if count == len(ends) else random.Random(SEED).sample(ends, count)
    timed = _timed(graph, speed)
    flows = nx.edge_betweenness_centrality_subset(timed, starts, ends, normalized=False, weight=_TAKES)
    targets, trips = set(ends), 0
    for start in starts:
        reached: set[str] = nx.descendants(timed, start)
        trips += len(targets & reached)
    shares: dict[tuple[str, str], float] = {}
    for (start, end), flow in flows.items():
        if flow > 0.0:
            lane = (start, end) if start < end else (end, start)
            shares[lane] = shares.get(lane, 0.0) + flow / trips
    ranked = sorted(shares.items(), key=lambda one: (-round(one[1], 9), one[0]))
    return Concentration(dict(ranked), between, count, len(ends), speed)


def _timed(graph: nx.DiGraph[str], speed: float) -> nx.DiGraph[str]:
    """Return the lanes that are not closed, with the microseconds that they take.

    With whole numbers, trips that are equally quick have exactly the same duration. Each lane takes at least one
    microsecond, as betweenness requires, although two waypoints may be at the same point.
    """
    timed: nx.DiGraph[str] = nx.DiGraph()
    timed.add_nodes_from(graph)
    for start, end, lane in graph.edges(data=True):
        if not lane["closed"]:
            seconds = lane["ride"] or lane["length"] / min(speed, lane["speed_limit"])
            timed.add_edge(start, end, **{_TAKES: max(1, round(_MICROSECONDS * seconds))})
    return timed
