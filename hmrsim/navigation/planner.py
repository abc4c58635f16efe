"""The quickest routes on the lanes of a world, some of which may be closed: one cached search per destination."""

from __future__ import annotations

import heapq
import math
from array import array
from collections.abc import Collection, Iterator, Sequence, Set
from dataclasses import dataclass
from typing import TYPE_CHECKING

from hmrsim.caches import LruCache, exact
from hmrsim.geometry import SAME_PLACE, Point, distance, foot
from hmrsim.navigation.route import Leg, Route

if TYPE_CHECKING:
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
    """The quickest ways from all waypoints to one destination; compact, since many trees are kept.

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
    """A cache of the trees of the latest destinations.

    Args:
        durations: How long each lane counts for.
        closed: The numbers of the edges that are not to be taken.
    """

    def __init__(self, lanes: Lanes, durations: Durations, closed: Collection[int] = ()) -> None:
        self._lanes = lanes
        self._durations = durations
        self._closed = closed
        self._kept_seconds: LruCache[float, array[float]] = LruCache(_KEPT_SPEEDS)
        most = min(_KEPT_TREES, max(64, _KEPT_NODES // max(1, len(lanes.names))))
        self._trees: LruCache[bytes, Tree] = LruCache(most)

    def __contains__(self, key: tuple[Point, float]) -> bool:
        """Return whether the tree of a destination and a speed is there."""
        goal, speed = key
        return exact(*goal, speed) in self._trees

    def to(self, goal: Point, speed: float) -> Tree:
        """Return the tree of a destination, from the cache if possible.

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
        """Return the travel time of each lane at a maximum speed, by number; infinite for closed lanes."""
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


_KEPT_ROUTES = 1_024
"""Routes that a planner keeps, from any point to any other: most robots drive the same ones again."""


@dataclass(frozen=True, slots=True)
class _Step:
    """The next step towards a destination.

    Attributes:
        way: The number of the lane to drive.
        leave: Where to leave it for the destination; None to drive it to its end.
    """

    way: int
    leave: Point | None = None


class Planner:
    """A planner of quickest routes on the lanes.

    Args:
        durations: How long each lane counts for.
        closed: The numbers of the edges that no robot may enter; a robot on one may leave it.
    """

    def __init__(self, lanes: Lanes, durations: Durations, closed: Collection[int] = ()) -> None:
        self._lanes = lanes
        self._durations = durations
        self._closed = closed
        self._trees = Trees(lanes, durations, closed)
        self._routes: LruCache[bytes, Route | None] = LruCache(_KEPT_ROUTES)

    def find_ways(self, goal: Point, speed: float) -> None:
        """Find the quickest ways to a destination from everywhere, so that to plan one takes no time.

        Raises:
            NoRoute: The goal is outside the map (204), or inside an obstacle (206).
        """
        self._trees.to(goal, speed if self._lanes.limited else 1.0)

    def seconds_to(self, goal: Point, speed: float) -> Sequence[float]:
        """Return how long the quickest way to a destination takes from each waypoint; infinite where none leads.

        Raises:
            NoRoute: As `find_ways` says.
        """
        speed = speed if self._lanes.limited else 1.0
        if (goal, speed) not in self._trees:
            self._lanes.check(goal)
        return self._trees.to(goal, speed).cost

    def plan(self, start: Point, goal: Point, speed: float) -> Route | None:
        """Return the quickest route for a robot of this greatest *speed*, by the rules of `WaypointGraph.plan`.

        Returns:
            None if no way leads there.

        Raises:
            NoRoute: The goal is outside the map (204), or inside an obstacle (206).
        """
        speed = speed if self._lanes.limited else 1.0
        return self._routes.get(exact(*start, *goal, speed), lambda: self._quickest(start, goal, speed))

    def _quickest(self, start: Point, goal: Point, speed: float) -> Route | None:
        """Return the quickest route; None when no way leads to the destination."""
        if distance(start, goal) <= SAME_PLACE:
            return Route(())
        at = self._lanes.at.get(start)
        if at is None or goal not in self._lanes.at:
            if (goal, speed) not in self._trees:
                self._lanes.check(goal)
            if self._straight(start, goal):
                return self._lanes.route([Leg(start, goal, distance(start, goal))], goal)
        if at is not None:
            tree = self._trees.to(goal, speed)
            legs = self._follow(at, tree) if tree.cost[at] < math.inf else None
            if legs and self._lanes.apart and legs[-1].lane is not None:
                # Whole lanes, each of which leads somewhere.
                return Route(tuple(legs), goal)
        else:
            legs = self._enter(start, goal, speed)
        return None if legs is None else self._lanes.route(legs, goal)

    def detour(self, start: Point, goal: Point, speed: float, avoid: Set[tuple[str, str]]) -> Route | None:
        """Return the quickest route from a waypoint that avoids some lanes; None if there is none.

        The kept tree says how long the rest takes at least, so that little has to be looked at (A*).
        """
        speed = speed if self._lanes.limited else 1.0
        avoided = {self._lanes.numbers[lane] for lane in avoid} | {*self._closed}
        tree, at, takes = self._trees.to(goal, speed), self._lanes.at[start], self._durations.at(speed)
        came: dict[int, int] = {}
        heap = [(tree.cost[at], 0.0, at, -1)]
        while heap:
            least, seconds, node, by = heapq.heappop(heap)
            if node in came or least == math.inf:
                continue
            came[node] = by
            rest = self._follow(node, tree)
            if avoid.isdisjoint([leg.lane for leg in rest]):
                return self._lanes.route([*self._back(node, came), *rest], goal)
            for edge in self._lanes.out[node]:
                if edge.number not in avoided and edge.end not in came:
                    total = seconds + takes[edge.number]
                    heapq.heappush(heap, (total + tree.cost[edge.end], total, edge.end, edge.number))
        return None

    def _back(self, node: int, came: dict[int, int]) -> list[Leg]:
        """Return the legs by which the search reached a waypoint."""
        legs = []
        while (number := came[node]) >= 0:
            legs.append(self._lanes.legs[number])
            node = self._lanes.ways.starts[number]
        return legs[::-1]

    def _straight(self, start: Point, goal: Point) -> bool:
        """Return whether the straight line is free and the lanes offer nothing better.

        That is where the straight line is no longer than the ways to the lanes and back, and where both are beside the
        same lane, with none nearer to either.
        """
        lanes, reach = self._lanes, self._lanes.away(start) + self._lanes.away(goal)
        if distance(start, goal) > reach + SAME_PLACE and not self._share_lane(start, goal):
            return False
        return lanes.clear(start, goal)

    def _share_lane(self, start: Point, goal: Point) -> bool:
        away, lanes = self._lanes.nearest(start)
        goal_away, goal_lanes = self._lanes.nearest(goal)
        return min(away, goal_away) > SAME_PLACE and not lanes.isdisjoint(goal_lanes)

    def _enter(self, start: Point, goal: Point, speed: float) -> list[Leg] | None:
        """Return the legs from a point that is no waypoint; None when no way leads to the destination.

        The lanes are entered at the nearest point that sees it and from which a way leads there.
        """
        tree = self._trees.to(goal, speed)
        on_lanes, _ = self._lanes.approaches(start)
        for joint in self._lanes.joints(start, lambda number: number in self._closed and not on_lanes):
            ways = [way for enter in joint for way in self._ways_from(enter, tree, speed)]
            if ways:
                enter, how = min(ways, key=lambda way: way[:2])[2:]
                at = self._lanes.ways.starts[enter.number]
                rest = self._take(enter.at, how, tree) if how else self._follow(at, tree)
                return _cut([Leg(start, enter.at, enter.away), *rest])
        return None

    def _ways_from(self, enter: Foot, tree: Tree, speed: float) -> Iterator[tuple[int, float, Foot, _Step | None]]:
        """Yield the ways from a point of a lane to the destination: tier, seconds, and what to do at the point.

        Where that is nothing, the way is that of the waypoint where the lane begins.
        """
        ways, number = self._lanes.ways, enter.number
        to_lane, lane_speed = enter.away / speed, min(speed, ways.limits.get(number, math.inf))
        end, start = ways.ends[number], ways.starts[number]
        if tree.cost[end] < math.inf:
            seconds = to_lane + enter.left / lane_speed + tree.cost[end]
            yield tree.tiers.get(end, 0), seconds, enter, _Step(number)
        if enter.along <= SAME_PLACE and tree.cost[start] < math.inf:
            yield tree.tiers.get(start, 0), to_lane + tree.cost[start], enter, None
        if number in tree.leaves:
            tier, leave = tree.leaves[number]
            if leave.along >= enter.along:
                seconds = to_lane + distance(enter.at, leave.at) / lane_speed + leave.away / speed
                yield tier, seconds, enter, _Step(number, leave.at)

    def _take(self, start: Point, how: _Step, tree: Tree) -> list[Leg]:
        """Return the legs from a point of a lane to the destination, when *how* is what to do there."""
        legs = [self._leg(start, how, tree)]
        if how.leave is None:
            return legs + self._follow(self._lanes.ways.ends[how.way], tree)
        return [*legs, Leg(how.leave, tree.goal, distance(how.leave, tree.goal))]

    def _follow(self, node: int, tree: Tree) -> list[Leg]:
        """Return the legs from a waypoint to the destination."""
        legs: list[Leg] = []
        whole, ends, step, leave = self._lanes.legs, self._lanes.ways.ends, tree.step, tree.leave
        while (number := step[node]) >= 0:
            if leave and node in leave:
                return legs + self._take(self._lanes.points[node], _Step(number, leave[node]), tree)
            legs.append(whole[number])
            node = ends[number]
        return legs

    def _leg(self, start: Point, how: _Step, tree: Tree) -> Leg:
        """Return the leg that a step drives on its lane; it ends exactly at a destination on the lane."""
        leg = self._lanes.legs[how.way]
        if how.leave is None and start == leg.start:
            return leg
        end = leg.end if how.leave is None else (tree.goal if tree.on_lanes else how.leave)
        slots = leg.slots if end == leg.end else leg.slots[:1]
        return Leg(start, end, distance(start, end), leg.lane, leg.speed_limit, slots)


def _cut(legs: list[Leg]) -> list[Leg]:
    """Return legs without a detour: a robot on its way from the lanes to the destination does not turn back to them."""
    start, last = legs[0].start, legs[-1]
    if last.lane is None and distance(start, foot(start, last.start, last.end)) <= SAME_PLACE:
        return [Leg(start, last.end, distance(start, last.end))]
    return legs
