"""Nav2's actions on the route graph, whose waypoints have ids."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

from py_trees.common import Status

from bt_controller.core.action_node import ACTION_INPUTS, ACTION_OUTPUTS, ActionNode
from bt_controller.core.node import Leaf, PortError
from bt_controller.core.ports import (
    BOOL,
    DURATION,
    INT,
    MAX_WAYPOINT_ID,
    PATH,
    POSE,
    POSES,
    ROUTE,
    WAYPOINT_ID,
    input_port,
    output_port,
)
from bt_controller.nodes import Family
from hmrsim.actions import registry
from hmrsim.interfaces import nav2_msgs
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.geometry_msgs import Pose, PoseStamped
from hmrsim.interfaces.nav2_msgs import Route

if TYPE_CHECKING:
    from hmrsim.interfaces.message import Message


class _RouteNode(ActionNode):
    """An action that finds a route."""

    INPUTS: ClassVar = {
        **ACTION_INPUTS,
        "goal": input_port(POSE, "Destination", required=False),
        "start": input_port(POSE, "Start, if use_start is true", required=False),
        "goal_id": input_port(WAYPOINT_ID, "Id of the last waypoint, without use_poses", default=0),
        "start_id": input_port(WAYPOINT_ID, "Id of the first waypoint, without use_poses", default=0),
        "use_start": input_port(BOOL, "Whether to use start, or else the robot's pose", default=False),
        "use_poses": input_port(BOOL, "Whether to use poses, or else the ids of waypoints", default=False),
    }

    def goal(self) -> Message:
        """Return the goal of the input ports.

        Raises:
            PortError: A port has no value, or no valid one.
        """
        message: Any = registry()[self.ACTION].goal
        fields: dict[str, Any]
        if self.read("use_poses"):
            start = {"use_start": True, "start": self._pose("start")} if self.read("use_start") else {}
            fields = {"use_poses": True, "goal": self._pose("goal"), **start}
        else:
            fields = {name: self._id(name) for name in ("start_id", "goal_id")}
        goal: Message = message(**fields)
        return goal

    def _pose(self, port: str) -> PoseStamped:
        pose: PoseStamped | None = self.read(port)
        if pose is None:
            raise PortError(f"{self._whose(port)} has no value yet")
        return pose

    def _id(self, port: str) -> int:
        number: int = self.read(port)
        if not 0 <= number <= MAX_WAYPOINT_ID:
            raise PortError(f"{self._whose(port)}: {number} is not the id of a waypoint, from 0 to {MAX_WAYPOINT_ID}")
        return number


class ComputeRoute(_RouteNode):
    """Finds the quickest route on the graph, and writes it and the path along it; empty ones if there is none."""

    ACTION = "compute_route"
    CLEARED = ("route", "path", "planning_time")
    OUTPUTS: ClassVar = {
        **ACTION_OUTPUTS,
        "route": output_port(ROUTE, "The route"),
        "path": output_port(PATH, "The path from the first waypoint of the route to the last"),
        "planning_time": output_port(DURATION, "Zero: planning takes no time"),
    }


class ComputeAndTrackRoute(_RouteNode):
    """Finds a route and follows the robot along it, whatever drives it; succeeds at its last waypoint.

    RUNNING until then, with the waypoints and the lane where the robot is on the output ports. When the input ports
    change, the new goal preempts the old one.
    """

    ACTION = "compute_and_track_route"
    OUTPUTS: ClassVar = {
        **ACTION_OUTPUTS,
        "execution_duration": output_port(DURATION, "How long it took"),
        "last_node_id": output_port(INT, "Id of the waypoint that the robot has passed; 0 for none"),
        "next_node_id": output_port(INT, "Id of the waypoint that comes next"),
        "current_edge_id": output_port(INT, "Id of the lane between them; 0 for none"),
        "route": output_port(ROUTE, "The route"),
        "path": output_port(PATH, "The path along it"),
        "rerouted": output_port(BOOL, "Whether the route is a new one"),
    }
    FEEDBACK_OUTPUTS = ("last_node_id", "next_node_id", "current_edge_id", "route", "path", "rerouted")

    def initialise(self) -> None:
        """Write that the robot is on no route yet, and send the goal."""
        if self.status is Status.INVALID:
            self.clear_result()
        super().initialise()

    def should_replace_goal(self) -> bool:
        """Return whether the goal of the input ports differs from the active one."""
        return bool(self.goal() != self._sent)

    def write_feedback(self, feedback: Any) -> None:
        """Write where the robot is on its route."""
        for port in self.FEEDBACK_OUTPUTS:
            self.write(port, getattr(feedback, port))

    def write_result(self, result: Any) -> None:
        """Write that the robot is on no route, and the duration."""
        self.clear_result()
        self.write("execution_duration", result.execution_duration)

    def clear_result(self) -> None:
        """Write that the robot is on no route."""
        self.write_feedback(nav2_msgs.ComputeAndTrackRoute.Feedback())
        self.write("execution_duration", Duration())


class ExtractRouteNodesAsGoals(Leaf):
    """Writes the waypoints of a route as poses to ``goals``; fails if it has none."""

    INPUTS: ClassVar = {"route": input_port(ROUTE, "The route", required=False)}
    OUTPUTS: ClassVar = {"goals": output_port(POSES, "A pose at each waypoint, without an orientation of its own")}

    def update(self) -> Status:
        """Write the poses."""
        route: Route = self.read("route") or Route()
        if not route.nodes:
            self.feedback_message = "the route has no waypoints"
            return Status.FAILURE
        poses = [PoseStamped(header=route.header, pose=Pose(position=node.position)) for node in route.nodes]
        self.write("goals", poses)
        return Status.SUCCESS


FAMILY = Family.of_module(__name__)
