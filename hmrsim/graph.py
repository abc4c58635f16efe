"""Routes on the waypoint graph; the only importer of networkx.

Planning works on plain lists (`hmrsim.lanes`, `hmrsim.search`). For all other questions the same graph is there as
one of networkx, which is loaded when somebody has such a question: it takes a third of the time and of the memory
that a simulator needs to start.
"""

from __future__ import annotations

import heapq
import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import count, pairwise
from typing import TYPE_CHECKING

from hmrsim.errors import NoRoute
from hmrsim.geometry import SAME_PLACE, Point, distance
from hmrsim.interfaces.nav2_msgs import ComputePathToPose
from hmrsim.lanes import START, Lanes
from hmrsim.route import Leg, Route
from hmrsim.search import Trees

if TYPE_CHECKING:
    from collections.abc import Sequence

    import networkx as nx

    from hmrsim.lanes import Edge
    from hmrsim.search import Tree
    from hmrsim.world.model import World

_KEPT_ROUTES = 4_096
"""Ways on to the lanes that are kept."""


@dataclass(frozen=True, slots=True)
class _Step:
    """What to do next on the way to a destination.

    Attributes:
        edge: The lane to take.
        leave: Where to leave it for the destination; None to drive it to its end.
    """

    edge: Edge
    leave: Point | None = None


class WaypointGraph:
    """Waypoints, lanes, and what stands around them.

    Args:
        world: Where they are. Its names must have been checked.

    Attributes:
        name: The world's.
        waypoints: Their points, by name.
        ways: All lanes in each direction in which they can be driven, by the waypoints where they begin.
    """

    def __init__(self, world: World) -> None:
        self.name = world.name
        self.waypoints = world.waypoints
        self._lanes = Lanes(world)
        self._trees = Trees(self._lanes)
        self.ways = self._lanes.ways
        self._entrance = lru_cache(_KEPT_ROUTES)(self._enter)

    @cached_property
    def graph(self) -> nx.DiGraph[str]:
        """The graph for networkx: nodes have ``point``; edges have ``length``, ``speed_limit`` and ``capacity``."""
        import networkx as nx  # noqa: PLC0415 - see above

        graph: nx.DiGraph[str] = nx.DiGraph(name=self.name)
        for name, point in self.waypoints.items():
            graph.add_node(name, point=point)
        for way in self.ways:
            graph.add_edge(way.start, way.end, length=way.length, speed_limit=way.speed_limit, capacity=way.capacity)
        return graph

    def parts(self) -> list[set[str]]:
        """Return the waypoints in sets that lanes connect, whatever their direction; the largest first."""
        import networkx as nx  # noqa: PLC0415 - see above

        return sorted(nx.weakly_connected_components(self.graph), key=len, reverse=True)

    def clear(self, a: Point, b: Point) -> bool:
        """Return whether nothing stands on the straight line from *a* to *b*."""
        return self._lanes.clear(a, b)

    def plan(self, start: Point, goal: Point, speed: float) -> Route:
        """Return the quickest route for a robot of this greatest *speed*.

        A point off the lanes is reached by the point of each lane that is nearest to it of those from which a clear
        straight line leads there; the lane that gives the quickest trip is taken. Equal trips are ordered by the
        names of their waypoints. Turning and acceleration are not counted.

        Raises:
            NoRoute: The goal is outside the map (204), inside an obstacle (206), or no way leads there (208).
        """
        if distance(start, goal) <= SAME_PLACE:
            return Route(())
        speed = speed if self._lanes.limited else 1.0
        if (goal, speed) not in self._trees:
            self._lanes.check(goal)
        at = self._lanes.at.get(start)
        if (at is None or goal not in self._lanes.at) and self._straight(start, goal):
            return _route([Leg(start, goal, distance(start, goal))])
        if at is not None:
            tree = self._trees.to(goal, speed)
            legs = self._follow(at, tree) if tree.cost[at] < math.inf else None
        else:
            legs = self._entrance(start, goal, speed)
        if legs is None:
            raise NoRoute(
                ComputePathToPose.Result.NO_VALID_PATH,
                f"no route from ({start[0]:g}, {start[1]:g}) to ({goal[0]:g}, {goal[1]:g})",
            )
        return _route(legs)

    def find_ways(self, goal: Point, speed: float) -> None:
        """Find the quickest ways to a destination from everywhere, so that to plan one takes no time.

        Raises:
            NoRoute: The goal is outside the map (204), or inside an obstacle (206).
        """
        self._lanes.check(goal)
        self._trees.to(goal, speed if self._lanes.limited else 1.0)

    def check_start(self, point: Point) -> None:
        """Do nothing if somebody can set out from *point*.

        Raises:
            NoRoute: It is outside the map (203) or inside an obstacle (205).
        """
        self._lanes.check(point, START)

    def straight_through(self, points: Sequence[Point]) -> tuple[Route, str]:
        """Return the straight legs from point to point as far as nothing stands in the way, and what does; or "".

        Between two points of one lane the lane is driven, which is open.
        """
        legs: list[Leg] = []
        for a, b in pairwise(points):
            if distance(a, b) <= SAME_PLACE:
                continue
            edge = self._lanes.edge_between(a, b)
            try:
                self._lanes.check(b)
            except NoRoute as wrong:
                if edge is None:
                    return _route(legs), str(wrong)
            if edge is None and not self._lanes.clear(a, b):
                return _route(legs), f"an obstacle stands between ({a[0]:g}, {a[1]:g}) and ({b[0]:g}, {b[1]:g})"
            lane, limit = (edge.leg.lane, edge.speed_limit) if edge else (None, math.inf)
            legs.append(Leg(a, b, distance(a, b), lane, limit))
        return _route(legs), ""

    def _straight(self, start: Point, goal: Point) -> bool:
        """Return whether both see each other and have a nearest lane in common, one of them being off the lanes."""
        away, lanes = self._lanes.nearest(start)
        goal_away, goal_lanes = self._lanes.nearest(goal)
        if away <= SAME_PLACE and goal_away <= SAME_PLACE:
            return False
        return (not self._lanes.edges or not lanes.isdisjoint(goal_lanes)) and self._lanes.clear(start, goal)

    # --- legs -----------------------------------------------------------------------------------------------------

    def _enter(self, start: Point, goal: Point, speed: float) -> list[Leg] | None:
        """Return the legs from a point that is no waypoint; None when no way leads to the destination."""
        tree = self._trees.to(goal, speed)
        on_lanes, feet = self._lanes.feet(start)
        ways: list[tuple[float, int, Point, _Step]] = []
        order = count()

        def offer(point: Point, how: _Step) -> None:
            seconds = self._seconds(start, point, how, tree, speed)
            if seconds < math.inf:
                heapq.heappush(ways, (seconds, next(order), point, how))

        for edge, point in feet:
            offer(point, _Step(edge))
            offer(point, _Step(edge, self._lanes.foot(tree.goal, edge)))
        while ways:
            _, _, point, how = heapq.heappop(ways)
            if not (on_lanes or self._lanes.clear(start, point)):
                for seen in self._lanes.seen(start, how.edge, point):
                    offer(seen, how)
            elif not (how.leave is None or tree.on_lanes or self._lanes.clear(how.leave, tree.goal)):
                for seen in self._lanes.seen(tree.goal, how.edge, how.leave):
                    offer(point, _Step(how.edge, seen))
            else:
                return [Leg(start, point, distance(start, point)), *self._take(point, how, tree)]
        return None

    def _seconds(self, start: Point, point: Point, how: _Step, tree: Tree, speed: float) -> float:
        """Return how long it takes by way of *point* on a lane; infinite if that leads nowhere, or backwards."""
        edge, leave = how.edge, how.leave
        to_lane, lane_speed = distance(start, point) / speed, min(speed, edge.speed_limit)
        if leave is None:
            return to_lane + distance(point, edge.leg.end) / lane_speed + tree.cost[edge.end]
        last = distance(leave, tree.goal)
        begin = edge.leg.start
        if distance(begin, leave) < distance(begin, point) or (tree.on_lanes and last > SAME_PLACE):
            return math.inf
        return to_lane + distance(point, leave) / lane_speed + last / speed

    def _take(self, start: Point, how: _Step, tree: Tree) -> list[Leg]:
        """Return the legs from a point of a lane to the destination, when *how* is what to do there."""
        legs = [self._leg(start, how, tree)]
        if how.leave is None:
            return legs + self._follow(how.edge.end, tree)
        return [*legs, Leg(how.leave, tree.goal, distance(how.leave, tree.goal))]

    def _follow(self, node: int, tree: Tree) -> list[Leg]:
        """Return the legs from a waypoint to the destination."""
        legs: list[Leg] = []
        edges, step, leave = self._lanes.edges, tree.step, tree.leave
        while (number := step[node]) >= 0:
            edge = edges[number]
            if node in leave:
                return legs + self._take(edge.leg.start, _Step(edge, leave[node]), tree)
            legs.append(edge.leg)
            node = edge.end
        return legs

    def _leg(self, start: Point, how: _Step, tree: Tree) -> Leg:
        """Return the leg that a step drives on its lane; it ends exactly at a destination on the lane."""
        edge = how.edge
        if how.leave is None and start == edge.leg.start:
            return edge.leg
        end = edge.leg.end if how.leave is None else (tree.goal if tree.on_lanes else how.leave)
        return Leg(start, end, distance(start, end), edge.leg.lane, edge.speed_limit)


def _route(legs: list[Leg]) -> Route:
    """Return the route of these legs, without those of no length."""
    return Route(tuple([leg for leg in legs if leg.length > 0.0]))
