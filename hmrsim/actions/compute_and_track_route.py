"""Find the quickest route on the graph, and report the robot's progress along it, whatever drives the robot.

A waypoint is achieved when the robot is at it, passes the line that halves the corner there, or comes near it and goes
away; the first and the last one when the robot comes near. How soon that can be is known from how far it is and how
fast the robot drives, so that little is looked at, and nothing while it stands.
"""

from __future__ import annotations

import math
from collections.abc import Generator
from typing import TYPE_CHECKING, Any, Final

from hmrsim.actions import Action, Codes, Report
from hmrsim.actions._navigation import path_values
from hmrsim.actions._routes import INPUTS, ends_of, find_route, frames_of, poses_on, route_values
from hmrsim.geometry import METER, SAME_PLACE, distance
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.nav2_msgs import ComputeAndTrackRoute

if TYPE_CHECKING:
    from hmrsim.actions._routes import GraphRoute
    from hmrsim.geometry import Point
    from hmrsim.navigation.graph import Lane
    from hmrsim.robots.robot import Robot


_NEAR: Final = 2.0
"""How near the robot has to come to a waypoint, in meters."""
_NEAR_END: Final = 1.0
"""How near it has to come to the first and the last one."""
_PERIOD: Final = 0.02
"""The shortest time between two looks, in seconds."""

_SPEED, _REROUTE = "AdjustSpeedLimit", "CollisionMonitor"
"""Nav2's operations that robots carry out by themselves: they keep to limits, and go around what is closed."""


class RouteTracker:
    """The progress of a robot along a route.

    Args:
        report: Is given the feedback when a waypoint is achieved and when the route changes.

    Raises:
        GoalAborted: There is no route.
    """

    def __init__(
        self, robot: Robot, goal: ComputeAndTrackRoute.Goal, report: Report[ComputeAndTrackRoute.Feedback]
    ) -> None:
        self._robot, self._report = robot, report
        self._ends = ends_of(robot, goal)
        self._last: str | None = None
        self._lane: Lane | None = None
        self._near = False
        self._limit = math.inf
        self._take(find_route(robot, self._ends))
        self._feedback: dict[str, Any] = {}

    def _take(self, route: GraphRoute) -> None:
        """Follow a route from its first waypoint, and go on with the lane that the robot is on if that leads there."""
        self._route, self._next = route, 0
        if self._lane is None or self._lane != route.first:
            self._last = self._lane = None
        self._near = False
        self._closed = self._robot.graph.closed
        self._values = {
            "route": route_values(self._robot, route),
            "path": path_values(self._robot, poses_on(self._robot, route)),
        }

    def track(self) -> Generator[Any, Any, None]:
        """Follow the robot until it has achieved the last waypoint.

        Raises:
            GoalAborted: A lane ahead has been closed, and there is no other route.
        """
        self._note(rerouted=True)
        self._report.sample(lambda: self._feedback)
        self._tell()
        while True:
            while self._achieved():
                if self._pass_on():
                    return
            if self._closed_ahead():
                self._take(find_route(self._robot, self._ends.from_robot()))
                self._note(rerouted=True)
                self._tell(_REROUTE)
                continue
            yield from self._robot.watch(self._soonest())

    def _pass_on(self) -> bool:
        """Go on to the next waypoint; return whether that was the last one."""
        nodes = self._route.nodes
        self._near = False
        self._last = nodes[self._next]
        self._next += 1
        if self._next == len(nodes):
            self._lane = None
            # The last feedback of a goal is sent at its end.
            self._note()
            return True
        self._lane = self._last, nodes[self._next]
        limit = self._robot.graph.speed_limit(self._lane)
        changed, self._limit = limit != self._limit, limit
        self._note()
        self._tell(*[_SPEED] * changed)
        return False

    def _note(self, *, rerouted: bool = False) -> None:
        """Record where the robot is on its route, for feedback until that changes."""
        ids, nodes = self._robot.graph.ids, self._route.nodes
        self._feedback = {
            "last_node_id": ids.nodes[self._last] if self._last else 0,
            "next_node_id": ids.nodes[nodes[self._next]] if self._next < len(nodes) else 0,
            "current_edge_id": ids.edges[self._lane] if self._lane else 0,
            **self._values,
            "operations_triggered": [],
            "rerouted": rerouted,
        }

    def _tell(self, *operations: str) -> None:
        self._report.send({**self._feedback, "operations_triggered": [*operations]})

    @property
    def _radius(self) -> float:
        return (_NEAR_END if self._at_end else _NEAR) * METER[self._robot.units]

    @property
    def _at_end(self) -> bool:
        """Return whether the next waypoint is the last one, or the first one of a robot that comes from no lane."""
        return self._lane is None or self._next == len(self._route.nodes) - 1

    def _achieved(self) -> bool:
        """Return whether the robot has achieved the next waypoint."""
        here, there = self._robot.pose().point, self._point(self._next)
        away = distance(here, there)
        near = away <= self._radius + SAME_PLACE
        if away <= SAME_PLACE or (self._near and not near):
            return True
        self._near = near
        return near and (self._at_end or self._before_line(here, there) <= SAME_PLACE)

    def _before_line(self, here: Point, there: Point) -> float:
        """Return how far the robot is before the line that halves the corner at the next waypoint."""
        before = self._robot.graph.waypoints[self._lane[0]] if self._lane else there
        after = self._point(self._next + 1)
        x = y = 0.0
        for a, b in ((before, there), (there, after)):
            length = distance(a, b)
            x, y = x + (b[0] - a[0]) / length, y + (b[1] - a[1]) / length
        size = distance((0.0, 0.0), (x, y))
        if size <= SAME_PLACE:
            # The route turns back: it has passed the waypoint when it is there, or goes away again.
            return distance(here, there)
        return (x * (there[0] - here[0]) + y * (there[1] - here[1])) / size

    def _point(self, number: int) -> Point:
        return self._robot.graph.waypoints[self._route.nodes[number]]

    def _closed_ahead(self) -> bool:
        """Return whether a lane has been closed that the robot has not begun."""
        closed = self._robot.graph.closed
        if closed == self._closed:
            return False
        begun = self._lane is None or self._robot.distance_to(self._robot.graph.waypoints[self._lane[0]]) > SAME_PLACE
        return not closed.isdisjoint(self._route.lanes[max(0, self._next - (not begun)) :])

    def _soonest(self) -> float:
        """Return in how many seconds the next waypoint can be achieved; infinite if not before the motion changes."""
        piece = self._robot.piece
        if piece is None or piece.leg is None or piece.leg.ride:
            return math.inf
        fastest = min(self._robot.speed, piece.leg.speed_limit)
        speed = fastest if piece.profile else piece.length / piece.duration
        here, there = self._robot.pose().point, self._point(self._next)
        away = distance(here, there)
        to_go = away - self._radius
        if self._near:
            to_go = min(self._radius - away, self._before_line(here, there))
        seconds = max(to_go / speed, _PERIOD)
        return seconds if seconds < piece.duration - self._robot.motion.elapsed else math.inf


def _process(
    robot: Robot, goal: ComputeAndTrackRoute.Goal, report: Report[ComputeAndTrackRoute.Feedback]
) -> Generator[Any, Any, ComputeAndTrackRoute.Result]:
    began = robot.now
    yield from RouteTracker(robot, goal, report).track()
    return ComputeAndTrackRoute.Result(execution_duration=Duration.from_seconds(robot.now - began))


ACTION = Action(
    name="compute_and_track_route",
    goal=ComputeAndTrackRoute.Goal,
    result=ComputeAndTrackRoute.Result,
    feedback=ComputeAndTrackRoute.Feedback,
    process=_process,
    failure=lambda code, message: ComputeAndTrackRoute.Result(error_code=code, error_msg=message),
    codes=Codes.of_nav2(ComputeAndTrackRoute.Result),
    holds_base=False,
    exclusive=True,
    frames=frames_of,
    inputs=INPUTS,
    example={"use_poses": True, "goal": {"pose": {"position": {"x": 0.5}}}},
)
