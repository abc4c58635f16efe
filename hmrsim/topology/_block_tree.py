"""The blocks of an undirected graph, and the vertices at which they are connected: the block-cut forest.

A block has no cut vertex. The parts that a vertex or an edge separates are subtrees of this forest, so that one walk
counts all of them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import accumulate
from typing import Generic, TypeVar, cast

import networkx as nx

T = TypeVar("T")

Stretches = tuple[range, ...]
"""Positions in the walk along the forest, which stand for one side of a vertex or edge."""


class BlockTree(Generic[T]):
    """Blocks and vertices, each with a number: vertices' numbers follow those of blocks.

    Args:
        graph: The graph; vertices without an edge are left out.
        weight: The weight of a vertex.
        names: What is at it.
        order: The order of the vertices in a block: networkx returns sets.

    Attributes:
        blocks: The vertices of each.
        cuts: The vertices that belong to several blocks.
    """

    def __init__(
        self,
        graph: nx.Graph[T],
        weight: Callable[[T], int],
        names: Mapping[T, Sequence[str]],
        order: Callable[[T], tuple[bool, str]],
    ) -> None:
        # The stubs call what is yielded a list of sets.
        blocks = cast("Iterable[set[T]]", nx.biconnected_components(graph))
        self.blocks = [sorted(block, key=order) for block in blocks]
        blocks_of: dict[T, list[int]] = {}
        for number, block in enumerate(self.blocks):
            for vertex in block:
                blocks_of.setdefault(vertex, []).append(number)
        self.cuts = [vertex for vertex, blocks in blocks_of.items() if len(blocks) > 1]
        self._number = {vertex: len(self.blocks) + i for i, vertex in enumerate(blocks_of)}
        self._neighbours = [[self._number[vertex] for vertex in block] for block in self.blocks]
        self._neighbours += blocks_of.values()
        self._parent, walk = self._walk()
        self._position = {number: i for i, number in enumerate(walk)}
        vertices: list[T | None] = [None] * len(self.blocks)
        vertices += blocks_of
        walked = [vertices[number] for number in walk]
        self._names = [name for vertex in walked if vertex is not None for name in names.get(vertex, ())]
        weights = (0 if vertex is None else weight(vertex) for vertex in walked)
        named = (0 if vertex is None else len(names.get(vertex, ())) for vertex in walked)
        # Sums over all that is before a position: what is below a number is one stretch of the walk.
        self._before = [list(accumulate(counts, initial=0)) for counts in (weights, named)]
        self._size, self._root = [1] * len(walk), list(range(len(walk)))
        for number in reversed(walk):
            if (parent := self._parent[number]) is not None:
                self._size[parent] += self._size[number]
        for number in walk:
            if (parent := self._parent[number]) is not None:
                self._root[number] = self._root[parent]

    def _walk(self) -> tuple[list[int | None], list[int]]:
        """Return the parent of each number, and all of them so that what is below one follows it at once."""
        count = len(self._neighbours)
        parent: list[int | None] = [None] * count
        walk: list[int] = []
        seen = [False] * count
        for root in range(count):
            stack = [] if seen[root] else [root]
            while stack:
                number = stack.pop()
                seen[number] = True
                walk.append(number)
                for other in self._neighbours[number]:
                    if not seen[other]:
                        parent[other] = number
                        stack.append(other)
        return parent, walk

    def sides(self, cut: T) -> list[Stretches]:
        """Return the parts on each side of a vertex, without it."""
        number = self._number[cut]
        return [self._beyond(number, block) for block in self._neighbours[number]]

    def ends(self, block: int) -> list[Stretches]:
        """Return what hangs on each vertex of a block, with that vertex."""
        return [self._beyond(block, vertex) for vertex in self._neighbours[block]]

    def counts(self, stretches: Stretches) -> tuple[int, int]:
        """Return what some stretches count, and how many names are there."""
        weight, names = (sum(before[part.stop] - before[part.start] for part in stretches) for before in self._before)
        return weight, names

    def names(self, stretches: Stretches) -> list[str]:
        """Return the names in some stretches."""
        before = self._before[1]
        return [name for part in stretches for name in self._names[before[part.start] : before[part.stop]]]

    def _beyond(self, number: int, other: int) -> Stretches:
        """Return the part on the side of *other*, a neighbour, when *number* is removed."""
        if self._parent[other] == number:
            return (self._below(other),)
        root, below = self._below(self._root[number]), self._below(number)
        return range(root.start, below.start), range(below.stop, root.stop)

    def _below(self, number: int) -> range:
        start = self._position[number]
        return range(start, start + self._size[number])
