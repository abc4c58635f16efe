"""Traffic concentration: the share of all quickest trips that take a lane, on a graph like `World.graph`."""

from __future__ import annotations

import random
from dataclasses import dataclass
from typing import Final

import networkx as nx

MAX_STEPS: Final = 2_000_000
"""Maximum number of lanes that are searched in all: some seconds."""
MIN_STARTS: Final = 8
"""Trips from fewer waypoints would say nothing; where there is no time for so many there is no answer."""
MIN_PLACES: Final = 3
"""Where fewer waypoints have places, trips lead from any waypoint to any other."""
SEED: Final = 1
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
