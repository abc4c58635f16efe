"""The quickest ways from all waypoints to a destination: one search per destination, whose tree is cached."""

from __future__ import annotations

import heapq
import math
from array import array
from collections.abc import Collection
from dataclasses import dataclass
from typing import TYPE_CHECKING

from hmrsim.navigation.cache import LruCache, exact

if TYPE_CHECKING:
    from hmrsim.geometry import Point
    from hmrsim.navigation.adjacency import Durations
    from hmrsim.navigation.lanes import Foot, Lanes

_TIE = 1e-9
"""Trips whose times differ by less than this share take equally long."""

_KEPT_SPEEDS = 16
"""Speeds for which it is kept how long each lane takes that is not closed."""

_KEPT_NODES = 4_000_000
"""Waypoints in all kept trees together: some 48 MB."""

_KEPT_TREES = 4_096
"""Trees that are kept, however small: clients may send robots to any point."""


@dataclass(frozen=True, slots=True)
class Tree:
    """The quickest ways to one destination; some 12 bytes a waypoint, as many of them are kept.

    Attributes:
        on_lanes: Whether it is on a lane, so that no route leaves the lanes for it.
        cost: Seconds from each waypoint; infinite where no way leads.
        step: Number of the lane to take at each waypoint; -1 at the destination itself, and where no way leads.
        leave: By waypoint, where to leave that lane for the destination; absent where it is driven to its end.
        tiers: By waypoint, how many lane points are nearer to the destination than the one to which its way leads, as
            they can't be reached from it; absent where there are none.
        leaves: By the number of a lane, where it is left for the destination, and the tier of that point.
    """

    goal: Point
    on_lanes: bool
    cost: array[float]
    step: array[int]
    leave: dict[int, Point]
    tiers: dict[int, int]
    leaves: dict[int, tuple[int, Foot]]


_Entry = tuple[float, int, int, int, "Foot | None"]
"""Seconds, a waypoint, what keeps entries apart, and what to do there: which lane to take, and where to leave it."""


class Trees:
    """The trees of the destinations that were asked for last.

    Args:
        durations: How long each lane counts for.
        closed: The numbers of the edges that are not to be taken.
    """

    def __init__(self, lanes: Lanes, durations: Durations, closed: Collection[int] = ()) -> None:
        self._lanes = lanes
        self._durations = durations
        self._closed = closed
        self._kept_seconds: LruCache[float, array[float]] = LruCache(_KEPT_SPEEDS)
        most = min(_KEPT_TREES, max(64, _KEPT_NODES // max(1, len(lanes.out))))
        self._trees: LruCache[bytes, Tree] = LruCache(most)

    def __contains__(self, key: tuple[Point, float]) -> bool:
        """Return whether the tree of a destination and a speed is there."""
        goal, speed = key
        return exact(*goal, speed) in self._trees

    def to(self, goal: Point, speed: float) -> Tree:
        """Return the tree of a destination, made now or kept from before.

        Raises:
            NoRoute: The goal is outside the map (204), or inside an obstacle (206).
        """
        return self._trees.get(exact(*goal, speed), lambda: self._search(goal, speed))

    def _search(self, goal: Point, speed: float) -> Tree:
        """Search backwards from *goal* for the quickest way from every waypoint.

        A goal beside the lanes is reached from the nearest lane point that sees it; waypoints from which no way leads
        there take the next nearest one.
        """
        lanes = self._lanes
        lanes.check(goal)
        cost = array("d", [math.inf]) * len(lanes.names)
        at = lanes.at.get(goal)
        on_lanes = at is not None or lanes.approaches(goal)[0]
        tree = Tree(goal, on_lanes, cost, array("i", [-1]) * len(lanes.names), {}, {}, {})
        if at is not None:
            self._spread(tree, [(0.0, at, 0, -1, None)], speed)
        else:
            starts, closed = lanes.ways.starts, self._closed
            joints = lanes.joints(goal, lambda number: number in closed or cost[starts[number]] < math.inf)
            for tier, joint in enumerate(joints):
                tree.leaves.update((foot.number, (tier, foot)) for foot in joint)
                reached = self._spread(tree, [self._leaving(foot, speed) for foot in joint], speed)
                if tier:
                    tree.tiers.update(dict.fromkeys(reached, tier))
        self._settle_ties(tree, speed)
        return tree

    def _spread(self, tree: Tree, heap: list[_Entry], speed: float) -> list[int]:
        """Add the ways from all waypoints that have none yet, and return these (Dijkstra)."""
        cost = tree.cost
        found, takes = [math.inf] * len(cost), self._seconds(speed)
        starts, (begins, into) = self._lanes.ways.starts, self._lanes.ways.into
        reached: list[int] = []
        heapq.heapify(heap)
        while heap:
            seconds, node, _, number, leave = heapq.heappop(heap)
            if cost[node] < math.inf or seconds == math.inf:
                continue
            if leave:
                tree.leave[node] = leave.at
            cost[node], tree.step[node] = seconds, number
            reached.append(node)
            for way in into[begins[node] : begins[node + 1]]:
                total = seconds + takes[way]
                start = starts[way]
                if total < found[start]:
                    found[start] = total
                    heapq.heappush(heap, (total, start, 2 * way, way, None))
        return reached

    def _seconds(self, speed: float) -> array[float]:
        """Return how long each lane takes at this greatest speed, by its number; infinitely long where it is closed."""
        if not self._closed:
            return self._durations.at(speed)
        return self._kept_seconds.get(speed, lambda: self._durations.without(self._closed, speed))

    def _leaving(self, leave: Foot, speed: float) -> _Entry:
        """Return what to do at the start of a lane that is left at a point for the destination."""
        ways, number = self._lanes.ways, leave.number
        along = leave.along / min(speed, ways.limits.get(number, math.inf))
        return along + leave.away / speed, ways.starts[number], 2 * number + 1, number, leave

    def _settle_ties(self, tree: Tree, speed: float) -> None:
        """Break ties between equally long ways by the name of the next waypoint."""
        cost, step, takes = tree.cost, tree.step, self._seconds(speed)
        ways = self._lanes.ways
        first, ends = ways.first, ways.ends
        # Nothing is to be settled where there is no choice.
        for node in ways.forks:
            number = step[node]
            if number < 0 or node in tree.leave:
                continue
            most, taken = cost[node] * (1 + _TIE), ends[number]
            for way in range(first[node], first[node + 1]):
                end = ends[way]
                if end >= taken:
                    break
                if cost[end] < cost[node] and cost[end] + takes[way] <= most:
                    step[node] = way
                    break
