"""Waypoints, lanes and lifts without which a graph like `World.graph` falls apart."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal, NamedTuple, TypeAlias

import networkx as nx

from hmrsim.topology._block_tree import BlockTree

if TYPE_CHECKING:
    from hmrsim.topology._block_tree import Stretches

MAX_LISTED: Final = 1_000
"""Bottlenecks that are listed with the parts that they separate; the others are counted."""


class _Lift(NamedTuple):
    """A lift, which is passed on the way from any of its stops to another."""

    lift: str


_Vertex: TypeAlias = "str | _Lift"


@dataclass(frozen=True)
class Side:
    """One side of a bottleneck.

    Attributes:
        waypoints: How many there are.
        places: The names of places and docks, in order.
    """

    waypoints: int
    places: tuple[str, ...]


@dataclass(frozen=True)
class Bottleneck:
    """A bottleneck: the graph falls apart when robots can't pass it.

    Attributes:
        kind: The kind of bottleneck.
        name: Of the waypoint or the lift; of the waypoints at both ends of a lane.
        sides: The separated parts, without a waypoint that is the bottleneck itself; the largest first.
    """

    kind: Literal["waypoint", "lane", "lift"]
    name: tuple[str, ...]
    sides: tuple[Side, ...]


@dataclass(frozen=True)
class Bottlenecks:
    """All bottlenecks of the graph.

    Attributes:
        worst: Those that separate most pairs of places, and then of waypoints, first; `MAX_LISTED` at most.
        waypoints: How many waypoints do: the graph's articulation points.
        lanes: How many lanes do: its bridges.
        lifts: How many lifts do.
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
    """Return what takes a graph apart: lanes that are not closed are passed in both directions here.

    A lift joins all its stops. It takes time like one depth-first search of the graph.
    """
    joined: nx.Graph[_Vertex] = nx.Graph()
    for start, end, lane in graph.edges(data=True):
        if lane["lift"]:
            joined.add_edges_from([(start, _Lift(lane["lift"])), (end, _Lift(lane["lift"]))])
        elif start != end and not lane["closed"]:
            joined.add_edge(start, end)
    places: dict[_Vertex, tuple[str, ...]] = {name: graph.nodes[name]["places"] for name in graph}
    tree = BlockTree(joined, _weight, places, _order)
    found = [*_vertices(tree), *_lanes(tree)]
    ranked = sorted(found, key=lambda one: (*(-pairs for pairs in _separated(tree, one)), one.kind, one.name))
    worst = tuple(Bottleneck(one.kind, one.name, _sides(tree, one)) for one in ranked[:MAX_LISTED])
    kinds = [one.kind for one in found]
    return Bottlenecks(worst, kinds.count("waypoint"), kinds.count("lane"), kinds.count("lift"))


def _weight(vertex: _Vertex) -> int:
    return int(isinstance(vertex, str))


def _order(vertex: _Vertex) -> tuple[bool, str]:
    return (True, vertex.lift) if isinstance(vertex, _Lift) else (False, vertex)


def _vertices(tree: BlockTree[_Vertex]) -> Iterator[_Found]:
    for vertex in tree.cuts:
        if isinstance(vertex, _Lift):
            yield _Found("lift", (vertex.lift,), tuple(tree.sides(vertex)))
            continue
        sides = tuple(side for side in tree.sides(vertex) if tree.counts(side)[0])
        if len(sides) > 1:
            yield _Found("waypoint", (vertex,), sides)


def _lanes(tree: BlockTree[_Vertex]) -> Iterator[_Found]:
    for number, block in enumerate(tree.blocks):
        if len(block) == 2 and not isinstance(block[1], _Lift):  # noqa: PLR2004
            yield _Found("lane", tuple(map(str, block)), tuple(tree.ends(number)))


def _separated(tree: BlockTree[_Vertex], found: _Found) -> tuple[int, int]:
    """Return how many pairs of names, and of waypoints, it separates."""
    waypoints, names = zip(*map(tree.counts, found.sides), strict=True)
    return _pairs(names), _pairs(waypoints)


def _pairs(sizes: tuple[int, ...]) -> int:
    return math.comb(sum(sizes), 2) - sum(math.comb(size, 2) for size in sizes)


def _sides(tree: BlockTree[_Vertex], found: _Found) -> tuple[Side, ...]:
    sides = [Side(tree.counts(side)[0], tuple(sorted(tree.names(side)))) for side in found.sides]
    return tuple(sorted(sides, key=lambda side: (-side.waypoints, -len(side.places), side.places)))
