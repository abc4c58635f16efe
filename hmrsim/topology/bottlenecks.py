"""Bottlenecks of a graph like `World.graph`: waypoints, lanes and lifts without which it falls apart."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate
from typing import Final, Literal, NamedTuple, TypeAlias, cast

import networkx as nx

MAX_LISTED: Final = 1_000
"""The number of bottlenecks that are listed with the parts that they separate; the others are only counted."""


class _Lift(NamedTuple):
    """A lift as a vertex, between all of its stops."""

    lift: str


_Vertex: TypeAlias = "str | _Lift"


@dataclass(frozen=True)
class Side:
    """One side of a bottleneck.

    Attributes:
        waypoints: The number of waypoints.
        places: The names of places and docks, in order.
    """

    waypoints: int
    places: tuple[str, ...]


@dataclass(frozen=True)
class Bottleneck:
    """A bottleneck: the graph falls apart when robots can't pass it.

    Attributes:
        kind: The kind of bottleneck.
        name: The name of the waypoint or the lift, or the names of the waypoints at both ends of the lane.
        sides: The separated parts, without a waypoint that is the bottleneck itself; the largest first.
    """

    kind: Literal["waypoint", "lane", "lift"]
    name: tuple[str, ...]
    sides: tuple[Side, ...]


@dataclass(frozen=True)
class Bottlenecks:
    """All bottlenecks of the graph.

    Attributes:
        worst: At most `MAX_LISTED` of them; those that separate the most pairs of places, then of waypoints, first.
        waypoints: The number of waypoints among them, which are the graph's articulation points.
        lanes: The number of lanes among them, which are its bridges.
        lifts: The number of lifts among them.
    """

    worst: tuple[Bottleneck, ...]
    waypoints: int
    lanes: int
    lifts: int


@dataclass(frozen=True)
class _Found:
    kind: Literal["waypoint", "lane", "lift"]
    name: tuple[str, ...]
    sides: tuple[Stretches, ...]


def bottlenecks(graph: nx.DiGraph[str]) -> Bottlenecks:
    """Return the waypoints, lanes and lifts that alone connect parts of a graph, whose lanes count in both directions.

    A lift joins all its stops. The time is that of a depth-first search of the graph.
    """
    joined: nx.Graph[_Vertex] = nx.Graph()
    for start, end, lane in graph.edges(data=True):
        if lane["lift"]:
            joined.add_edges_from([(start, _Lift(lane["lift"])), (end, _Lift(lane["lift"]))])
        elif start != end and not lane["closed"]:
            joined.add_edge(start, end)
    places: dict[_Vertex, tuple[str, ...]] = {name: graph.nodes[name]["places"] for name in graph}
    tree = _BlockTree(joined, places)
    found = [*_vertices(tree), *_lanes(tree)]
    ranked = sorted(found, key=lambda one: (*(-pairs for pairs in _separated(tree, one)), one.kind, one.name))
    worst = tuple(Bottleneck(one.kind, one.name, _sides(tree, one)) for one in ranked[:MAX_LISTED])
    kinds = [one.kind for one in found]
    return Bottlenecks(worst, kinds.count("waypoint"), kinds.count("lane"), kinds.count("lift"))


def _order(vertex: _Vertex) -> tuple[bool, str]:
    """Return the sort key of a vertex, since networkx returns sets."""
    return (True, vertex.lift) if isinstance(vertex, _Lift) else (False, vertex)


def _vertices(tree: _BlockTree) -> Iterator[_Found]:
    for vertex in tree.cuts:
        if isinstance(vertex, _Lift):
            yield _Found("lift", (vertex.lift,), tuple(tree.sides(vertex)))
            continue
        sides = tuple(side for side in tree.sides(vertex) if tree.counts(side)[0])
        if len(sides) > 1:
            yield _Found("waypoint", (vertex,), sides)


def _lanes(tree: _BlockTree) -> Iterator[_Found]:
    for number, block in enumerate(tree.blocks):
        if len(block) == 2 and not isinstance(block[1], _Lift):  # noqa: PLR2004
            yield _Found("lane", tuple(map(str, block)), tuple(tree.ends(number)))


def _separated(tree: _BlockTree, found: _Found) -> tuple[int, int]:
    """Return the numbers of pairs of names, and of waypoints, that a bottleneck separates."""
    waypoints, names = zip(*map(tree.counts, found.sides), strict=True)
    return _pairs(names), _pairs(waypoints)


def _pairs(sizes: tuple[int, ...]) -> int:
    return math.comb(sum(sizes), 2) - sum(math.comb(size, 2) for size in sizes)


def _sides(tree: _BlockTree, found: _Found) -> tuple[Side, ...]:
    sides = [Side(tree.counts(side)[0], tuple(sorted(tree.names(side)))) for side in found.sides]
    return tuple(sorted(sides, key=lambda side: (-side.waypoints, -len(side.places), side.places)))


class SingleTracks:
    """The narrow places of an undirected graph of lanes and rides, in which robots that meet can't pass each other.

    Args:
        graph: The graph, whose closed lanes do not count.
        rooms: The number of robots that may be at each waypoint at once.
    """

    def __init__(self, graph: nx.DiGraph[str], rooms: Mapping[str, float]) -> None:
        self._rooms = rooms
        self._graph: nx.Graph[str] = nx.Graph()
        for start, end, lane in graph.edges(data=True):
            if not lane["closed"]:
                self._graph.add_edge(start, end, both_ways=not lane["lift"] and graph.has_edge(end, start))

    @cached_property
    def parts(self) -> tuple[frozenset[str], ...]:
        """The waypoints of each connected part, sorted by the first name; waypoints without a lane are left out."""
        return tuple(sorted(map(frozenset, nx.connected_components(self._graph)), key=min))

    @cached_property
    def _cuts(self) -> frozenset[str]:
        return frozenset(nx.articulation_points(self._graph))

    @cached_property
    def _bridges(self) -> frozenset[frozenset[str]]:
        return frozenset(map(frozenset, nx.bridges(self._graph)))

    @cached_property
    def corridors(self) -> tuple[tuple[str, ...], ...]:
        """Chains of waypoints with room for one robot each, in which two robots that meet can't pass each other.

        There is no other route between the ends of a chain, so that one of the two robots has to go back. A chain has
        at least two waypoints: at a single one, a robot meets another one that is still outside, and can go aside.
        """
        narrow = {name for name, lanes in self._graph.degree() if lanes <= 2 and self._rooms[name] == 1}  # noqa: PLR2004
        chains: nx.Graph[str] = nx.Graph()
        for a, b in self._bridges:
            if {a, b} <= narrow and self._graph.edges[a, b]["both_ways"]:
                chains.add_edge(a, b)
        return tuple(sorted(self._from_end_to_end(chains)))

    def _from_end_to_end(self, chains: nx.Graph[str]) -> Iterator[tuple[str, ...]]:
        """Yield the waypoints of each chain, from the end whose name comes first."""
        for chain in nx.connected_components(chains):
            first = min(name for name in chain if chains.degree(name) == 1)
            yield tuple(nx.dfs_preorder_nodes(chains, first))

    def cut_off(self, *place: str) -> frozenset[str]:
        """Return the waypoints that a robot cuts off which stands at a waypoint, or on a lane between two waypoints.

        There are none if another route leads around it. Of the parts on its sides, all but the largest are cut off.
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
        """Return the number of robots for which there is room at the waypoints of a part."""
        return math.fsum(self._rooms[name] for name in part)

    def room_aside(self, part: frozenset[str]) -> float:
        """Return the number of robots that can stand in a part so that another one can still pass everywhere."""
        return math.fsum(self._rooms[name] - (name in self._cuts) for name in part)


Stretches = tuple[range, ...]
"""Ranges of positions in the walk along the forest, which together are one side of a vertex or edge."""


class _BlockTree:
    """The tree of a graph's blocks and vertices, numbered together: first the blocks, then the vertices.

    Args:
        graph: The graph; vertices without an edge are left out.
        places: The names of the places at each waypoint.

    Attributes:
        blocks: The vertices of each.
        cuts: The vertices that belong to several blocks.
    """

    def __init__(self, graph: nx.Graph[_Vertex], places: Mapping[_Vertex, Sequence[str]]) -> None:
        # The stubs call what is yielded a list of sets.
        blocks = cast("Iterable[set[_Vertex]]", nx.biconnected_components(graph))
        self.blocks = [sorted(block, key=_order) for block in blocks]
        blocks_of: dict[_Vertex, list[int]] = {}
        for number, block in enumerate(self.blocks):
            for vertex in block:
                blocks_of.setdefault(vertex, []).append(number)
        self.cuts = [vertex for vertex, blocks in blocks_of.items() if len(blocks) > 1]
        self._number = {vertex: len(self.blocks) + i for i, vertex in enumerate(blocks_of)}
        self._neighbors = [[self._number[vertex] for vertex in block] for block in self.blocks]
        self._neighbors += blocks_of.values()
        self._parent, walk = self._walk()
        self._position = {number: i for i, number in enumerate(walk)}
        vertices: list[_Vertex | None] = [None] * len(self.blocks)
        vertices += blocks_of
        walked = [vertices[number] for number in walk]
        named = [() if vertex is None else places.get(vertex, ()) for vertex in walked]
        self._names = [name for names in named for name in names]
        # Sums over all that is before a position: what is below a number is one stretch of the walk.
        waypoints = [isinstance(vertex, str) for vertex in walked]
        self._before = [[*accumulate(counts, initial=0)] for counts in (waypoints, map(len, named))]
        self._size, self._root = [1] * len(walk), list(range(len(walk)))
        for number in reversed(walk):
            if (parent := self._parent[number]) is not None:
                self._size[parent] += self._size[number]
        for number in walk:
            if (parent := self._parent[number]) is not None:
                self._root[number] = self._root[parent]

    def _walk(self) -> tuple[list[int | None], list[int]]:
        """Return the parent of each number, and all numbers so that descendants directly follow their ancestor."""
        count = len(self._neighbors)
        parent: list[int | None] = [None] * count
        walk: list[int] = []
        seen = [False] * count
        for root in range(count):
            stack = [] if seen[root] else [root]
            while stack:
                number = stack.pop()
                seen[number] = True
                walk.append(number)
                for other in self._neighbors[number]:
                    if not seen[other]:
                        parent[other] = number
                        stack.append(other)
        return parent, walk

    def sides(self, cut: _Vertex) -> list[Stretches]:
        """Return the parts on each side of a vertex, without it."""
        number = self._number[cut]
        return [self._beyond(number, block) for block in self._neighbors[number]]

    def ends(self, block: int) -> list[Stretches]:
        """Return, for each vertex of a block, the parts beyond it, with the vertex."""
        return [self._beyond(block, vertex) for vertex in self._neighbors[block]]

    def counts(self, stretches: Stretches) -> tuple[int, int]:
        """Return the number of waypoints in some stretches, and the number of names."""
        numbers = (sum(before[part.stop] - before[part.start] for part in stretches) for before in self._before)
        waypoints, names = numbers
        return waypoints, names

    def names(self, stretches: Stretches) -> list[str]:
        """Return the names in some stretches."""
        before = self._before[1]
        return [name for part in stretches for name in self._names[before[part.start] : before[part.stop]]]

    def _beyond(self, number: int, other: int) -> Stretches:
        """Return the part on the side of *other*, a neighbor, when *number* is removed."""
        if self._parent[other] == number:
            return (self._below(other),)
        root, below = self._below(self._root[number]), self._below(number)
        return range(root.start, below.start), range(below.stop, root.stop)

    def _below(self, number: int) -> range:
        start = self._position[number]
        return range(start, start + self._size[number])
