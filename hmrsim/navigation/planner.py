"""The quickest routes on the lanes of a world, some of which may be closed."""

from __future__ import annotations

import heapq
import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import count
from typing import TYPE_CHECKING

from hmrsim.errors import NoRoute
from hmrsim.geometry import SAME_PLACE, Point, distance, foot
from hmrsim.interfaces.nav2_msgs import ComputePathToPose
from hmrsim.navigation.kept import Kept, exact
from hmrsim.navigation.route import Leg, Route
from hmrsim.navigation.search import Trees

if TYPE_CHECKING:
    from hmrsim.navigation.durations import Durations
    from hmrsim.navigation.lanes import Foot, Lanes
    from hmrsim.navigation.search import Tree

_KEPT_ROUTES = 256
"""Ways on to the lanes that a planner keeps, such as those from where robots were canceled."""


@dataclass(frozen=True, slots=True)
class _Step:
    """What to do next on the way to a destination.

    Attributes:
        way: The number of the lane to drive.
        leave: Where to leave it for the destination; None to drive it to its end.
    """

    way: int
    leave: Point | None = None


class Planner:
    """Plans routes.

    Args:
        durations: How long each lane counts for.
        closed: The numbers of the edges that no robot may enter; a robot on one may leave it.
    """

    def __init__(self, lanes: Lanes, durations: Durations, closed: Collection[int] = ()) -> None:
        self._lanes = lanes
        self._durations = durations
        self._closed = closed
        self._trees = Trees(lanes, durations, closed)
        self._entrances: Kept[bytes, list[Leg] | None] = Kept(_KEPT_ROUTES)

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

    def plan(self, start: Point, goal: Point, speed: float) -> Route:
        """Return the quickest route for a robot of this greatest *speed*, by the rules of `WaypointGraph.plan`.

        Raises:
            NoRoute: The goal is outside the map (204), inside an obstacle (206), or no way leads there (208).
        """
        if distance(start, goal) <= SAME_PLACE:
            return Route(())
        speed = speed if self._lanes.limited else 1.0
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
            legs = self._entrances.get(exact(*start, *goal, speed), lambda: self._enter(start, goal, speed))
        if legs is None:
            raise NoRoute(
                ComputePathToPose.Result.NO_VALID_PATH,
                f"no route from ({start[0]:g}, {start[1]:g}) to ({goal[0]:g}, {goal[1]:g})",
            )
        return self._lanes.route(legs, goal)

    def detour(self, start: Point, goal: Point, speed: float, avoid: Collection[tuple[str, str]]) -> Route | None:
        """Return the quickest route from a waypoint that takes none of some lanes; None if there is none.

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
            if not any(leg.lane in avoid for leg in rest):
                return self._lanes.route([*self._back(node, came), *rest], goal)
            for edge in self._lanes.out[node]:
                if edge.number not in avoided and edge.end not in came:
                    total = seconds + takes[edge.number]
                    heapq.heappush(heap, (total + tree.cost[edge.end], total, edge.end, edge.number))
        return None

    def _back(self, node: int, came: dict[int, int]) -> list[Leg]:
        """Return the legs by which one came to a waypoint."""
        legs = []
        while (number := came[node]) >= 0:
            legs.append(self._lanes.legs[number])
            node = self._lanes.ways.starts[number]
        return legs[::-1]

    def _straight(self, start: Point, goal: Point) -> bool:
        """Return whether both see each other and have a nearest lane in common, one of them being off the lanes."""
        away, lanes = self._lanes.nearest(start)
        goal_away, goal_lanes = self._lanes.nearest(goal)
        if away <= SAME_PLACE and goal_away <= SAME_PLACE:
            return False
        return (not self._lanes.driven or not lanes.isdisjoint(goal_lanes)) and self._lanes.clear(start, goal)

    def _enter(self, start: Point, goal: Point, speed: float) -> list[Leg] | None:
        """Return the legs from a point that is no waypoint; None when no way leads to the destination."""
        tree = self._trees.to(goal, speed)
        on_lanes, feet = self._lanes.approaches(start)
        ways: list[tuple[float, int, Foot, Foot | None]] = []
        order = count()

        def offer(enter: Foot, leave: Foot | None) -> None:
            seconds = self._seconds(enter, leave, tree, speed)
            if seconds < math.inf:
                heapq.heappush(ways, (seconds, next(order), enter, leave))

        _, leaves = self._lanes.approaches(goal)
        for enter in feet.values() if on_lanes else self._open(feet):
            offer(enter, None)
            if enter.number in leaves:
                offer(enter, leaves[enter.number])
        while ways:
            _, _, enter, leave = heapq.heappop(ways)
            if not (on_lanes or self._lanes.clear(start, enter.at)):
                for seen in self._lanes.seen(start, enter):
                    offer(seen, leave)
            elif not (leave is None or tree.on_lanes or self._lanes.clear(leave.at, tree.goal)):
                for seen in self._lanes.seen(tree.goal, leave):
                    offer(enter, seen)
            else:
                how = _Step(enter.number, None if leave is None else leave.at)
                return _cut([Leg(start, enter.at, enter.away), *self._take(enter.at, how, tree)])
        return None

    def _open(self, feet: Mapping[int, Foot]) -> Iterator[Foot]:
        """Yield those of some points that are on lanes which are not closed."""
        return (foot for number, foot in feet.items() if number not in self._closed)

    def _seconds(self, enter: Foot, leave: Foot | None, tree: Tree, speed: float) -> float:
        """Return how long it takes from one point of a lane to another; infinite if that leads nowhere, or backwards.

        *leave* is where one leaves the lane for the destination; None to drive it to its end.
        """
        ways, number = self._lanes.ways, enter.number
        to_lane, lane_speed = enter.away / speed, min(speed, ways.limits.get(number, math.inf))
        if leave is None:
            return to_lane + enter.left / lane_speed + tree.cost[ways.ends[number]]
        if leave.along < enter.along or (tree.on_lanes and leave.away > SAME_PLACE):
            return math.inf
        return to_lane + distance(enter.at, leave.at) / lane_speed + leave.away / speed

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
