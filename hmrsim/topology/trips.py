"""Trips between places: how long they take, which are impossible, and how many of them take a lane."""

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
"""Maximum number of lanes that are searched for all destinations together: some seconds."""
MAX_PLACES: Final = 100
SEED: Final = 1


@dataclass(frozen=True)
class Trip:
    """A trip without turning and acceleration.

    Attributes:
        start: Name of the place or dock where it begins.
        goal: Likewise where it leads.
        length: In the world's unit.
        seconds: At the speed of these trips.
    """

    start: str
    goal: str
    length: float
    seconds: float


@dataclass(frozen=True)
class Trips:
    """The quickest trips between places and docks.

    Attributes:
        found: All of them, in order of the names.
        failed: Trips for which there is no route, and why.
        places: Between how many places they are.
        of: How many there are; more than *places* where they are too many, of which they are a sample that is always
            the same.
        speed: Of the robots, in the world's unit a second.
    """

    found: tuple[Trip, ...]
    failed: dict[tuple[str, str], str]
    places: int
    of: int
    speed: float


def speeds_of(world: World) -> dict[float, tuple[str, ...]]:
    """Return the speeds of robots that drive, with their types; that of most robots first.

    It is the speed of a robot without one, and no type, where no robot drives.
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
    """Return how long trips take robots of another speed, for which other ways may be quicker, by their ends."""
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
        strong: How many waypoints there are in each part within which all reach each other; the largest first.
        gaps: By place or dock, those that no way leads to; in order of name.
        pairs: How many pairs of places and docks these are, a pair for each direction.
    """

    strong: tuple[int, ...]
    gaps: dict[str, tuple[str, ...]]
    pairs: int


def parts(graph: nx.DiGraph[str]) -> list[int]:
    """Return how many waypoints there are in each part that lanes connect in any direction; the largest first.

    Closed lanes count: the parts are those of the map as it is drawn.
    """
    return sorted(map(len, nx.weakly_connected_components(graph)), reverse=True)


def reach(graph: nx.DiGraph[str]) -> Reach:
    """Return the waypoints that can be reached from each waypoint on lanes that are not closed.

    A place is reached where its waypoint is; a place at the waypoint of another one is reached from there.
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
    """Return the graph without its closed lanes; itself, if it has none."""
    closed = [(start, end) for start, end, lane in graph.edges(data=True) if lane["closed"]]
    if not closed:
        return graph
    found = nx.DiGraph(graph)
    found.remove_edges_from(closed)
    return found


MAX_STEPS: Final = 2_000_000
"""Maximum number of lanes that are searched in all: some seconds."""
MIN_STARTS: Final = 8
"""Trips from fewer waypoints would say nothing; where there is no time for so many there is no answer."""
MIN_PLACES: Final = 3
"""Where fewer waypoints have places, trips lead from any waypoint to any other."""
_MICROSECONDS: Final = 1e6
_TAKES: Final = "takes"


@dataclass(frozen=True)
class Concentration:
    """The share of trips on each lane, with one trip from each start to each destination.

    Attributes:
        shares: By the waypoints at both ends of a lane or ride, in order of name, with the share of trips that take
            it, whatever their direction; the greatest first. Equally quick ways share a trip.
        between: ``places`` (and docks), or ``waypoints`` where few have names.
        starts: From how many waypoints trips are counted.
        of: How many there are; more than *starts* in a large graph, of which they are a sample that is always the same.
        speed: Of the robots, in the world's unit a second.
    """

    shares: dict[tuple[str, str], float]
    between: str
    starts: int
    of: int
    speed: float


def concentration(graph: nx.DiGraph[str], speed: float) -> Concentration | None:
    """Return where traffic of robots of this greatest *speed* concentrates: edge betweenness, by travel time.

    Closed lanes are not taken. None where the graph is too large for `MAX_STEPS`.
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
    """Return the lanes that are not closed, with how long they take in microseconds.

    Whole numbers make equally quick trips exactly so. Betweenness needs lanes that take time, and two waypoints may be
    at the same point.
    """
    timed: nx.DiGraph[str] = nx.DiGraph()
    timed.add_nodes_from(graph)
    for start, end, lane in graph.edges(data=True):
        if not lane["closed"]:
            seconds = lane["ride"] or lane["length"] / min(speed, lane["speed_limit"])
            timed.add_edge(start, end, **{_TAKES: max(1, round(_MICROSECONDS * seconds))})
    return timed
