"""Single tracks, where robots can't pass each other, on a graph like `World.graph`: corridors and bottlenecks."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from functools import cached_property

import networkx as nx


class SingleTracks:
    """The lanes and rides of a graph without direction, and how many robots there is room for at each waypoint.

    Args:
        graph: Its lanes that are closed do not count.
        rooms: By waypoint, how many robots may be there at once.
    """

    def __init__(self, graph: nx.DiGraph[str], rooms: Mapping[str, float]) -> None:
        self._rooms = rooms
        self._graph: nx.Graph[str] = nx.Graph()
        for start, end, lane in graph.edges(data=True):
            if not lane["closed"]:
                self._graph.add_edge(start, end, both_ways=not lane["lift"] and graph.has_edge(end, start))

    @cached_property
    def parts(self) -> tuple[frozenset[str], ...]:
        """The waypoints of each part that is connected, in order of the first ones; without those of no lane."""
        return tuple(sorted(map(frozenset, nx.connected_components(self._graph)), key=min))

    @cached_property
    def _cuts(self) -> frozenset[str]:
        return frozenset(nx.articulation_points(self._graph))

    @cached_property
    def _bridges(self) -> frozenset[frozenset[str]]:
        return frozenset(map(frozenset, nx.bridges(self._graph)))

    @cached_property
    def corridors(self) -> tuple[tuple[str, ...], ...]:
        """Chains of waypoints with room for one each, in which two robots that meet can't pass, nor go around.

        There is no other way between their ends. One of the two could only go back where the other one has to go. Two
        waypoints make a chain: at a single one a robot meets another one that is still outside, and can go aside.
        """
        narrow = {name for name, lanes in self._graph.degree() if lanes <= 2 and self._rooms[name] == 1}  # noqa: PLR2004
        chains: nx.Graph[str] = nx.Graph()
        for a, b in self._bridges:
            if {a, b} <= narrow and self._graph.edges[a, b]["both_ways"]:
                chains.add_edge(a, b)
        return tuple(sorted(self._from_end_to_end(chains)))

    def _from_end_to_end(self, chains: nx.Graph[str]) -> Iterator[tuple[str, ...]]:
        """Yield the waypoints of each chain, from the end that comes first by name."""
        for chain in nx.connected_components(chains):
            first = min(name for name in chain if chains.degree(name) == 1)
            yield tuple(nx.dfs_preorder_nodes(chains, first))

    def cut_off(self, *place: str) -> frozenset[str]:
        """Return the waypoints to which no way leads past a robot that stands at a waypoint, or between two on a lane.

        There are none where another way leads around. Of the parts on its sides, the largest one is not cut off.
        """
        is_only_way = place[0] in self._cuts if len(place) == 1 else frozenset(place) in self._bridges
        if not is_only_way:
            return frozenset()
        rest: nx.Graph[str] = nx.Graph(self._graph)
        if len(place) > 1:
            beside = [*place]
            rest.remove_edge(*place)
        else:
            beside = [*rest[place[0]]]
            rest.remove_node(place[0])
        sides = {frozenset(nx.node_connected_component(rest, name)) for name in beside}
        *smaller, _ = sorted(sides, key=lambda side: (len(side), min(side)))
        return frozenset[str]().union(*smaller)

    def room(self, part: frozenset[str]) -> float:
        """Return for how many robots there is room at the waypoints of a part."""
        return math.fsum(self._rooms[name] for name in part)

    def room_aside(self, part: frozenset[str]) -> float:
        """Return how many robots can stand there so that one more passes wherever there is but one way."""
        return math.fsum(self._rooms[name] - (name in self._cuts) for name in part)
