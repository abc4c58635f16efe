"""Routes on the graph, as Nav2's route server has them: waypoints, and the lanes between them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from hmrsim.actions._inputs import Input
from hmrsim.actions._navigation import point_of
from hmrsim.errors import GoalAborted, NoRoute
from hmrsim.geometry import SAME_PLACE, Pose, distance, heading
from hmrsim.interfaces.nav2_msgs import ComputePathToPose, ComputeRoute

if TYPE_CHECKING:
    from hmrsim.geometry import Point
    from hmrsim.interfaces.nav2_msgs import ComputeAndTrackRoute
    from hmrsim.navigation.graph import Lane
    from hmrsim.navigation.route import Leg
    from hmrsim.robots.robot import Robot

    Goal = ComputeRoute.Goal | ComputeAndTrackRoute.Goal

INPUTS: Final = {
    "use_poses": Input("By poses", default=True),
    "goal": Input("Goal pose"),
    "goal_id": Input("Goal waypoint's id", advanced=True),
    "start_id": Input("Start waypoint's id", advanced=True),
}
"""What people are asked for."""

_CODES = ComputeRoute.Result
_MAX_ID: Final = 2**16 - 1
"""Of waypoints and lanes in messages."""


@dataclass(frozen=True)
class GraphRoute:
    """A route from waypoint to waypoint.

    Attributes:
        nodes: The waypoints that the robot passes, in order; one at least.
        first: The lane on whose rest the robot gets to the first of them; None if it is on none.
        seconds: The travel time from the first waypoint to the last.
    """

    nodes: tuple[str, ...]
    first: Lane | None = None
    seconds: float = 0.0

    @property
    def lanes(self) -> tuple[Lane, ...]:
        """The lanes between the waypoints."""
        return tuple(pairwise(self.nodes))


class Ends(NamedTuple):
    """The start and the end of a route.

    Attributes:
        start: None for where the robot is.
        first: The waypoint that it has to begin with; None for any.
        last: The one that it has to end with.
    """

    start: Point | None
    end: Point
    first: str | None = None
    last: str | None = None

    def from_robot(self) -> Ends:
        """Return the same from where the robot is."""
        return self._replace(start=None, first=None)


def ends_of(robot: Robot, goal: Goal) -> Ends:
    """Return where the route of a goal begins and ends.

    Raises:
        GoalAborted: There is no such waypoint, or no graph.
    """
    ids = robot.graph.ids
    if not ids.nodes:
        raise GoalAborted(_CODES.NO_VALID_GRAPH, "the world has no waypoints")
    if (last := len(ids.nodes) + len(ids.edges) - 1) > _MAX_ID:
        text = f"the ids of waypoints and lanes go up to {last}, and those of messages to {_MAX_ID}"
        raise GoalAborted(_CODES.NO_VALID_GRAPH, text)
    if goal.use_poses:
        return Ends(point_of(goal.start) if goal.use_start else None, point_of(goal.goal))
    names, points = [_waypoint(robot, number) for number in (goal.start_id, goal.goal_id)], robot.graph.waypoints
    return Ends(points[names[0]], points[names[1]], *names)


def _waypoint(robot: Robot, number: int) -> str:
    names = [*robot.graph.ids.nodes]
    if number >= len(names):
        raise GoalAborted(_CODES.UNKNOWN, f"no waypoint has the id {number}; ids are 0 to {len(names) - 1}")
    return names[number]


def find_route(robot: Robot, ends: Ends) -> GraphRoute:
    """Return the quickest route, from the first waypoint that it passes to the last.

    If it passes none, which is so on one lane, it is the waypoint nearest to its end.

    Raises:
        GoalAborted: There is none.
    """
    try:
        legs = robot.plan_on_lanes(ends.end, ends.start).legs
    except NoRoute as error:
        none = error.code == ComputePathToPose.Result.NO_VALID_PATH
        code = _CODES.NO_VALID_ROUTE if none else _CODES.INDETERMINANT_NODES_ON_GRAPH
        raise GoalAborted(code, str(error), error.cause) from None
    waypoints = robot.graph.waypoints
    nodes = tuple(dict.fromkeys(name for leg in legs for name in _passed(leg, waypoints)))
    if not nodes:
        nodes = (ends.last or min(waypoints, key=lambda name: (distance(waypoints[name], ends.end), name)),)
    if (ends.first or nodes[0], ends.last or nodes[-1]) != (nodes[0], nodes[-1]):
        # A robot would drive beside the lanes, to or from a waypoint that none of them has.
        raise GoalAborted(_CODES.NO_VALID_ROUTE, f"no lanes lead from {ends.first or nodes[0]!r} to {ends.last!r}")
    whole = set(pairwise(nodes))
    before = next((leg.lane for leg in legs if leg.lane), None)
    first = before if before and before not in whole and before[1] == nodes[0] else None
    return GraphRoute(nodes, first, sum(leg.seconds(robot.speed) for leg in legs if leg.lane in whole))


def _passed(leg: Leg, waypoints: dict[str, Point]) -> Iterator[str]:
    """Yield the waypoints at the ends of a leg."""
    for name, point in zip(leg.lane or (), (leg.start, leg.end), strict=False):
        if distance(waypoints[name], point) <= SAME_PLACE:
            yield name


def route_values(robot: Robot, route: GraphRoute) -> dict[str, Any]:
    """Return the plain values of a nav2_msgs/msg/Route; the cost is in seconds."""
    ids, points = robot.graph.ids, robot.graph.waypoints
    return {
        "header": robot.stamped(robot.pose())["header"],
        "route_cost": route.seconds,
        "nodes": [{"nodeid": ids.nodes[name], "position": _position(points[name])} for name in route.nodes],
        "edges": [
            {"edgeid": ids.edges[lane], "start": _position(points[lane[0]]), "end": _position(points[lane[1]])}
            for lane in route.lanes
        ],
    }


def _position(point: Point) -> dict[str, float]:
    return {"x": point[0], "y": point[1], "z": 0.0}


def poses_on(robot: Robot, route: GraphRoute) -> list[Pose]:
    """Return the poses of the path along a route, one at each waypoint, facing the way that it goes on or has come."""
    points = [robot.graph.waypoints[name] for name in route.nodes]
    yaws = [heading(a, b) for a, b in pairwise(points)]
    return [Pose(*point, yaw) for point, yaw in zip(points, [*yaws, *(yaws[-1:] or [0.0])], strict=True)]


def frames_of(goal: Goal) -> tuple[str, ...]:
    """Return the frames that a goal refers to."""
    if not goal.use_poses:
        return ()
    return (goal.goal.header.frame_id, goal.start.header.frame_id if goal.use_start else "")
