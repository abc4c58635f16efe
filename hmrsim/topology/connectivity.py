"""Pairs of places that no route connects, on a graph like `World.graph`."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass

import networkx as nx


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
    """Return what can be reached from what on lanes that are not closed.

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
