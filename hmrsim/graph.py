"""Routes on the waypoint graph; the only importer of networkx.

Planning works on plain lists: one Dijkstra search per destination gives the quickest way from everywhere, and these
trees are kept. For all other questions the same graph is there as one of networkx, which is loaded when somebody
has such a question: it takes a third of the time and of the memory that a simulator needs to start.
"""

from __future__ import annotations

import heapq
import math
from array import array
from collections import OrderedDict
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from itertools import count, pairwise
from typing import TYPE_CHECKING

from hmrsim.errors import NoRoute
from hmrsim.geometry import SAME_PLACE, Obstacles, Point, Pose, distance, foot, heading
from hmrsim.interfaces.nav2_msgs import ComputePathToPose
from hmrsim.world.model import FARTHEST

if TYPE_CHECKING:
    from collections.abc import Sequence

    import networkx as nx

    from hmrsim.world.model import World

_TIE = 1e-9
"""Trips whose times differ by less than this share take equally long."""

_KEPT_NODES = 4_000_000
"""Waypoints in all kept trees together: some 48 MB."""


_KEPT_ROUTES = 4_096
"""Ways on to the lanes that are kept."""


@dataclass(frozen=True, slots=True)
class Leg:
    """A straight piece of a route.

    Attributes:
        start: Where it begins.
        end: Where it ends.
        length: In the world's unit.
        lane: The waypoints of the lane that it runs on, in its direction; None off the lanes.
        speed_limit: Most that may be driven there; infinite without a limit.
        first: The pose of a robot that begins to drive it.
        last: The pose of one that has driven it.
    """

    start: Point
    end: Point
    length: float
    lane: tuple[str, str] | None = None
    speed_limit: float = math.inf
    first: Pose = field(init=False, compare=False, repr=False)
    last: Pose = field(init=False, compare=False, repr=False)

    def __post_init__(self) -> None:
        """Turn a robot into the leg's direction: every drive needs it, and most legs are driven often."""
        yaw = heading(self.start, self.end)
        object.__setattr__(self, "first", Pose(*self.start, yaw))
        object.__setattr__(self, "last", Pose(*self.end, yaw))


@dataclass(frozen=True, slots=True)
class Way:
    """A lane in one direction.

    Attributes:
        start: Name of the waypoint where it begins.
        end: Name of the waypoint where it ends.
        length: In the world's unit.
        speed_limit: Most that may be driven there; infinite without a limit.
        capacity: How many robots may be on it at once; None for any number.
    """

    start: str
    end: str
    length: float
    speed_limit: float
    capacity: int | None


@dataclass(frozen=True, slots=True)
class Route:
    """The way from one point to another: legs in order, none when they are the same place."""

    legs: tuple[Leg, ...]

    @property
    def length(self) -> float:
        """The length of all legs, in the world's unit."""
        return math.fsum(leg.length for leg in self.legs)


@dataclass(frozen=True, slots=True)
class _Edge:
    """A lane in one direction.

    Attributes:
        number: Its index among all.
        start: Index of the waypoint where it begins; indices order as names do.
        end: Likewise where it ends.
        length: In the world's unit.
        speed_limit: Most that may be driven there; infinite without a limit.
        leg: All of it, as part of a route.
    """

    number: int
    start: int
    end: int
    length: float
    speed_limit: float
    leg: Leg


@dataclass(frozen=True, slots=True)
class _Step:
    """What to do next on the way to a destination.

    Attributes:
        edge: The lane to take.
        leave: Where to leave it for the destination; None to drive it to its end.
    """

    edge: _Edge
    leave: Point | None = None


@dataclass(frozen=True, slots=True)
class _Tree:
    """The quickest ways to one destination; some 12 bytes a waypoint, as many of them are kept.

    Attributes:
        goal: The destination.
        on_lanes: Whether it is on a lane, so that nobody leaves the lanes for it.
        cost: Seconds from each waypoint; infinite where no way leads.
        step: Number of the lane to take at each waypoint; -1 at the destination itself, and where no way leads.
        leave: By waypoint, where to leave that lane for the destination; absent where it is driven to its end.
    """

    goal: Point
    on_lanes: bool
    cost: array[float]
    step: array[int]
    leave: dict[int, Point]


_Entry = tuple[float, int, int, int, Point | None]
"""Seconds, a waypoint, what keeps entries apart, and what to do there: which lane to take, and where to leave it."""


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
        self.ways = _ways(world)
        self._bounds = world.bounds
        self._obstacles = Obstacles(
            [wall for wall in world.walls if isinstance(wall, tuple)],
            [wall.solid for wall in world.walls if not isinstance(wall, tuple)],
        )
        self._trees: OrderedDict[tuple[Point, float], _Tree] = OrderedDict()
        self._compile()

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

    def _compile(self) -> None:
        """Make the lists that planning works on; names in order, so that an index orders as its name."""
        self._names = sorted(self.waypoints)
        self._points: list[Point] = [self.waypoints[name] for name in self._names]
        index = {name: i for i, name in enumerate(self._names)}
        self._edges: list[_Edge] = []
        for way in sorted(self.ways, key=lambda way: (way.start, way.end)):
            start, end = index[way.start], index[way.end]
            leg = Leg(self._points[start], self._points[end], way.length, (way.start, way.end), way.speed_limit)
            self._edges.append(_Edge(len(self._edges), start, end, way.length, way.speed_limit, leg))
        self._out: list[list[_Edge]] = [[] for _ in self._names]
        self._into: list[list[_Edge]] = [[] for _ in self._names]
        for edge in self._edges:
            self._out[edge.start].append(edge)
            self._into[edge.end].append(edge)
        # A waypoint that no lane touches is a point off the lanes like any other.
        self._at = {point: i for i, point in enumerate(self._points) if self._out[i] or self._into[i]}
        self._limited = any(edge.speed_limit < math.inf for edge in self._edges)
        self._most_trees = max(64, _KEPT_NODES // max(1, len(self._names)))
        self._trees.clear()
        self._nearest = lru_cache(_KEPT_ROUTES)(self._find_nearest)
        self._entrance = lru_cache(_KEPT_ROUTES)(self._enter)

    # --- questions ------------------------------------------------------------------------------------------------

    def check(self, point: Point) -> None:
        """Do nothing if somebody can be at *point*.

        Raises:
            NoRoute: It is outside the map (204) or inside an obstacle (206).
        """
        x, y = point
        if max(abs(x), abs(y)) > FARTHEST:
            raise NoRoute(
                ComputePathToPose.Result.GOAL_OUTSIDE_MAP,
                f"target ({x:g}, {y:g}) is outside any map: coordinates end at {FARTHEST:g}",
            )
        if self._bounds is not None:
            x0, y0, x1, y1 = self._bounds
            if not (x0 <= x <= x1 and y0 <= y <= y1):
                raise NoRoute(
                    ComputePathToPose.Result.GOAL_OUTSIDE_MAP,
                    f"target ({x:g}, {y:g}) is outside the map, which spans ({x0:g}, {y0:g}) to ({x1:g}, {y1:g})",
                )
        if self._obstacles.occupy(point):
            raise NoRoute(ComputePathToPose.Result.GOAL_OCCUPIED, f"target ({x:g}, {y:g}) is inside an obstacle")

    def clear(self, a: Point, b: Point) -> bool:
        """Return whether nothing stands on the straight line from *a* to *b*."""
        return not self._obstacles.block(a, b)

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
        speed = speed if self._limited else 1.0
        if (goal, speed) not in self._trees:
            self.check(goal)
        at = self._at.get(start)
        if (at is None or goal not in self._at) and self._straight(start, goal):
            return _route([Leg(start, goal, distance(start, goal))])
        if at is not None:
            tree = self._tree(goal, speed)
            legs = self._follow(at, tree) if tree.cost[at] < math.inf else None
        else:
            legs = self._entrance(start, goal, speed)
        if legs is None:
            raise NoRoute(
                ComputePathToPose.Result.NO_VALID_PATH,
                f"no route from ({start[0]:g}, {start[1]:g}) to ({goal[0]:g}, {goal[1]:g})",
            )
        return _route(legs)

    def straight_through(self, points: Sequence[Point]) -> tuple[Route, str]:
        """Return the straight legs from point to point as far as nothing stands in the way, and what does; or "".

        Between two points of one lane the lane is driven, which is open.
        """
        legs: list[Leg] = []
        for a, b in pairwise(points):
            if distance(a, b) <= SAME_PLACE:
                continue
            edge = self._edge_between(a, b)
            try:
                self.check(b)
            except NoRoute as wrong:
                if edge is None:
                    return _route(legs), str(wrong)
            if edge is None and not self.clear(a, b):
                return _route(legs), f"an obstacle stands between ({a[0]:g}, {a[1]:g}) and ({b[0]:g}, {b[1]:g})"
            lane, limit = (edge.leg.lane, edge.speed_limit) if edge else (None, math.inf)
            legs.append(Leg(a, b, distance(a, b), lane, limit))
        return _route(legs), ""

    def _edge_between(self, a: Point, b: Point) -> _Edge | None:
        """Return the lane on which one drives from *a* to *b*; None if there is none."""
        for edge in self._edges:
            begin = self._points[edge.start]
            on_it = all(distance(point, self._foot(point, edge)) <= SAME_PLACE for point in (a, b))
            if on_it and distance(begin, a) < distance(begin, b):
                return edge
        return None

    def _straight(self, start: Point, goal: Point) -> bool:
        """Return whether both see each other and have a nearest lane in common, one of them being off the lanes."""
        away, lanes = self._nearest(start)
        goal_away, goal_lanes = self._nearest(goal)
        if away <= SAME_PLACE and goal_away <= SAME_PLACE:
            return False
        return (not self._edges or not lanes.isdisjoint(goal_lanes)) and self.clear(start, goal)

    def _find_nearest(self, point: Point) -> tuple[float, set[tuple[int, int]]]:
        """Return how far the nearest lane is, and all lanes as near as that."""
        nearest = math.inf
        lanes: set[tuple[int, int]] = set()
        for edge in self._edges:
            away = distance(point, self._foot(point, edge))
            if away < nearest - SAME_PLACE:
                nearest, lanes = away, set()
            if away <= nearest + SAME_PLACE:
                lanes.add((min(edge.start, edge.end), max(edge.start, edge.end)))
        return nearest, lanes

    def _foot(self, point: Point, edge: _Edge) -> Point:
        return foot(point, self._points[edge.start], self._points[edge.end])

    def _feet(self, point: Point) -> tuple[bool, list[tuple[_Edge, Point]]]:
        """Return whether *point* is on a lane, and the nearest point of each lane: of those that it is on, if any."""
        feet = [(edge, self._foot(point, edge)) for edge in self._edges]
        here = [(edge, at) for edge, at in feet if distance(point, at) <= SAME_PLACE]
        return bool(here), here or feet

    # --- trees ----------------------------------------------------------------------------------------------------

    def _tree(self, goal: Point, speed: float) -> _Tree:
        """Return the tree of a destination, made now or kept from before."""
        key = (goal, speed)
        tree = self._trees.get(key)
        if tree is None:
            tree = self._trees[key] = self._search(goal, speed)
            if len(self._trees) > self._most_trees:
                self._trees.popitem(last=False)
        else:
            self._trees.move_to_end(key)
        return tree

    def _search(self, goal: Point, speed: float) -> _Tree:
        """Search backwards from *goal* for the quickest way from every waypoint (Dijkstra)."""
        cost = array("d", [math.inf]) * len(self._names)
        tree = _Tree(goal, goal in self._at, cost, array("i", [-1]) * len(self._names), {})
        found = cost[:]
        if tree.on_lanes:
            heap: list[_Entry] = [(0.0, self._at[goal], 0, -1, None)]
        else:
            on_lane, feet = self._feet(goal)
            tree = replace(tree, on_lanes=on_lane)
            heap = [self._leaving(edge, point, goal, speed) for edge, point in feet]
            heapq.heapify(heap)
        while heap:
            seconds, node, _, number, leave = heapq.heappop(heap)
            if cost[node] <= seconds:
                continue
            if leave:
                # Whether the line is clear is asked only of lanes that would be taken: it is the dear question.
                if not (tree.on_lanes or self.clear(leave, goal)):
                    edge = self._edges[number]
                    for seen in self._seen(goal, edge, leave):
                        heapq.heappush(heap, self._leaving(edge, seen, goal, speed))
                    continue
                tree.leave[node] = leave
            cost[node], tree.step[node] = seconds, number
            for edge in self._into[node]:
                total = seconds + edge.length / min(speed, edge.speed_limit)
                if total < found[edge.start]:
                    found[edge.start] = total
                    heapq.heappush(heap, (total, edge.start, 2 * edge.number, edge.number, None))
        self._settle_ties(tree, speed)
        return tree

    def _leaving(self, edge: _Edge, leave: Point, goal: Point, speed: float) -> _Entry:
        """Return what to do at the start of a lane that is left at a point for the destination."""
        along = distance(edge.leg.start, leave) / min(speed, edge.speed_limit)
        return along + distance(leave, goal) / speed, edge.start, 2 * edge.number + 1, edge.number, leave

    def _settle_ties(self, tree: _Tree, speed: float) -> None:
        """Where several ways take equally long, choose the next waypoint that comes first by name."""
        cost, step = tree.cost, tree.step
        for node, number in enumerate(step):
            if number < 0 or node in tree.leave:
                continue
            most, taken = cost[node] * (1 + _TIE), self._edges[number].end
            for edge in self._out[node]:
                if edge.end >= taken:
                    break
                if cost[edge.end] < cost[node] and cost[edge.end] + edge.length / min(speed, edge.speed_limit) <= most:
                    step[node] = edge.number
                    break

    # --- legs -----------------------------------------------------------------------------------------------------

    def _enter(self, start: Point, goal: Point, speed: float) -> list[Leg] | None:
        """Return the legs from a point that is no waypoint; None when no way leads to the destination."""
        tree = self._tree(goal, speed)
        on_lanes, feet = self._feet(start)
        ways: list[tuple[float, int, Point, _Step]] = []
        order = count()

        def offer(point: Point, how: _Step) -> None:
            seconds = self._seconds(start, point, how, tree, speed)
            if seconds < math.inf:
                heapq.heappush(ways, (seconds, next(order), point, how))

        for edge, point in feet:
            offer(point, _Step(edge))
            offer(point, _Step(edge, self._foot(tree.goal, edge)))
        while ways:
            _, _, point, how = heapq.heappop(ways)
            if not (on_lanes or self.clear(start, point)):
                for seen in self._seen(start, how.edge, point):
                    offer(seen, how)
            elif not (how.leave is None or tree.on_lanes or self.clear(how.leave, tree.goal)):
                for seen in self._seen(tree.goal, how.edge, how.leave):
                    offer(point, _Step(how.edge, seen))
            else:
                return [Leg(start, point, distance(start, point)), *self._take(point, how, tree)]
        return None

    def _seconds(self, start: Point, point: Point, how: _Step, tree: _Tree, speed: float) -> float:
        """Return how long it takes by way of *point* on a lane; infinite if that leads nowhere, or backwards."""
        edge, leave = how.edge, how.leave
        to_lane, lane_speed = distance(start, point) / speed, min(speed, edge.speed_limit)
        if leave is None:
            return to_lane + distance(point, self._points[edge.end]) / lane_speed + tree.cost[edge.end]
        last = distance(leave, tree.goal)
        begin = self._points[edge.start]
        if distance(begin, leave) < distance(begin, point) or (tree.on_lanes and last > SAME_PLACE):
            return math.inf
        return to_lane + distance(point, leave) / lane_speed + last / speed

    def _seen(self, eye: Point, edge: _Edge, hidden: Point) -> list[Point]:
        """Return the points of a lane that are next best to its foot, if that is what is hidden."""
        if hidden != self._foot(eye, edge):
            return []
        return self._obstacles.edges_of_shadow(eye, self._points[edge.start], self._points[edge.end])

    def _take(self, start: Point, how: _Step, tree: _Tree) -> list[Leg]:
        """Return the legs from a point of a lane to the destination, when *how* is what to do there."""
        legs = [self._leg(start, how, tree)]
        if how.leave is None:
            return legs + self._follow(how.edge.end, tree)
        return [*legs, Leg(how.leave, tree.goal, distance(how.leave, tree.goal))]

    def _follow(self, node: int, tree: _Tree) -> list[Leg]:
        """Return the legs from a waypoint to the destination."""
        legs: list[Leg] = []
        edges, step, leave = self._edges, tree.step, tree.leave
        while (number := step[node]) >= 0:
            edge = edges[number]
            if node in leave:
                return legs + self._take(edge.leg.start, _Step(edge, leave[node]), tree)
            legs.append(edge.leg)
            node = edge.end
        return legs

    def _leg(self, start: Point, how: _Step, tree: _Tree) -> Leg:
        """Return the leg that a step drives on its lane; it ends exactly at a destination on the lane."""
        edge = how.edge
        if how.leave is None and start == edge.leg.start:
            return edge.leg
        end = self._points[edge.end] if how.leave is None else (tree.goal if tree.on_lanes else how.leave)
        return Leg(start, end, distance(start, end), edge.leg.lane, edge.speed_limit)


def _route(legs: list[Leg]) -> Route:
    """Return the route of these legs, without those of no length."""
    return Route(tuple([leg for leg in legs if leg.length > 0.0]))


def _ways(world: World) -> tuple[Way, ...]:
    """Return the lanes of a world in each direction; of two between the same waypoints the last one counts."""
    found: dict[str, dict[str, Way]] = {name: {} for name in world.waypoints}
    for lane in world.lanes:
        length = distance(world.waypoints[lane.from_], world.waypoints[lane.to])
        ends = [(lane.from_, lane.to)] if lane.one_way else [(lane.from_, lane.to), (lane.to, lane.from_)]
        for start, end in ends:
            found[start][end] = Way(start, end, length, lane.speed_limit or math.inf, lane.capacity)
    return tuple(way for ways in found.values() for way in ways.values())
