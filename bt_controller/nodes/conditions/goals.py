"""Nav2's conditions on goals and paths: whether a goal has changed or is near, and whether a path is open.

Lengths are in the world's unit.

IsPathValid compares the simulator's open lanes with those of earlier queries. A path is closed where it enters a lane
that was open earlier and is not open now. A robot on such a lane may leave it. A segment that has never been a lane
counts as open: the planner has considered the walls, which do not move.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise
from typing import TYPE_CHECKING, Any, ClassVar

from py_trees.common import Status

from bt_controller.core.node import Condition
from bt_controller.core.ports import (
    BOOL,
    DOUBLE,
    FINITE,
    INT,
    PATH,
    POSE,
    POSES,
    STRING,
    TRACKING,
    input_port,
    output_port,
)
from bt_controller.nodes import Family
from bt_controller.nodes.poses import (
    BASE_FRAME,
    GLOBAL_FRAME,
    GOAL_PORTS,
    Located,
    Trail,
    apart,
    goals_of,
    length_of,
    point_of,
)
from hmrsim.errors import HmrsimError
from hmrsim.geometry import SAME_PLACE, Point, distance, foot
from hmrsim_zenoh.wire.descriptions import plain_values
from hmrsim_zenoh.wire.envelopes import UnreadableError

if TYPE_CHECKING:
    from hmrsim.interfaces.nav2_msgs import TrackingFeedback
    from hmrsim.interfaces.nav_msgs import Path
    from hmrsim_zenoh.client.client import Client


def _if(true: bool) -> Status:  # noqa: FBT001 - a conversion of a bool
    return Status.SUCCESS if true else Status.FAILURE


class GoalReached(Located, Condition):
    """Succeeds if the robot is within 0.25 of ``goal``, whatever its orientation."""

    INPUTS: ClassVar = {
        "goal": input_port(POSE, "Destination"),
        "global_frame": GLOBAL_FRAME,
        "robot_base_frame": BASE_FRAME,
    }
    TOLERANCE: ClassVar = 0.25

    def update(self) -> Status:
        """Compare the robot's pose with the goal."""
        return _if(apart(self.read("goal"), self.here) <= self.TOLERANCE)


class GoalUpdated(Condition):
    """Succeeds if ``goal`` or ``goals`` have changed since the last tick; fails at the first tick after being idle."""

    INPUTS: ClassVar = GOAL_PORTS

    _known: Any = None

    def update(self) -> Status:
        """Compare the goals with those of the last tick."""
        known, self._known = self._known, goals_of(self)
        return _if(self.status is not Status.INVALID and known != self._known)


class GlobalUpdatedGoal(GoalUpdated):
    """Succeeds at its first tick, and whenever ``goal`` or ``goals`` have changed since its last tick, idle or not."""

    def update(self) -> Status:
        """Compare the goals with those of the last tick."""
        known, self._known = self._known, goals_of(self)
        return _if(known != self._known or known is None)


class IsGoalNearby(Located, Condition):
    """Succeeds if less than ``proximity_threshold`` of the path remains after its point closest to the robot.

    The search for that point covers the whole path, or ``max_robot_pose_search_dist`` after the previous one. Fails if
    there is no path.
    """

    INPUTS: ClassVar = {
        "path": input_port(PATH, "The path", required=False),
        "proximity_threshold": input_port(FINITE, "Threshold of the remaining length", default=1.0),
        "max_robot_pose_search_dist": input_port(DOUBLE, "Search distance; negative for the whole path", default=-1.0),
        "global_frame": GLOBAL_FRAME,
        "robot_base_frame": BASE_FRAME,
    }

    def __init__(self, name: str, behaviour_class_name: str | None = None) -> None:
        super().__init__(name, behaviour_class_name=behaviour_class_name)
        self._trail = Trail()

    def update(self) -> Status:
        """Compare the remaining length of the path with the threshold."""
        path = self.read("path")
        if path is None or not path.poses:
            self.feedback_message = "there is no path"
            return Status.FAILURE
        ahead = self.read("max_robot_pose_search_dist")
        reached = self._trail.reached(path, self.here, ahead=math.inf if ahead < 0.0 else ahead)
        return _if(length_of(path) - reached < self.read("proximity_threshold"))


class ArePosesNear(Condition):
    """Succeeds if two poses are within ``tolerance`` of each other."""

    INPUTS: ClassVar = {
        "ref_pose": input_port(POSE, "One pose"),
        "target_pose": input_port(POSE, "The other"),
        "tolerance": input_port(FINITE, "Largest distance", default=0.5),
        "global_frame": GLOBAL_FRAME,
    }

    def update(self) -> Status:
        """Compare the distance of the poses with the tolerance."""
        return _if(apart(self.read("ref_pose"), self.read("target_pose")) <= self.read("tolerance"))


_NO_COSTMAP = "Ignored: there is no costmap"


class IsPathValid(Condition):
    """Succeeds if a path is open: if it enters no lane that was open earlier and is not open now.

    Faults, doors and obstacles close lanes. A robot on a closed lane may leave it. A path without poses is not valid.
    For an invalid path, ``collision_poses`` has the pose after which it is closed, or all such poses with
    ``stop_at_first_collision="false"``.
    """

    INPUTS: ClassVar = {
        "path": input_port(PATH, "The path", required=False),
        "stop_at_first_collision": input_port(BOOL, "Whether to output the first pose only", default=True),
        "max_cost": input_port(INT, _NO_COSTMAP, default=254),
        "consider_unknown_as_obstacle": input_port(BOOL, _NO_COSTMAP, default=False),
        "layer_name": input_port(STRING, _NO_COSTMAP, default=""),
        "footprint": input_port(STRING, "Ignored: footprints matter between robots only", default=""),
        "max_lookahead_distance": input_port(DOUBLE, "Ignored: the whole path is checked", default=-1.0),
        "service_name": input_port(STRING, "Ignored: the open lanes come from the simulator", required=False),
        "server_timeout": input_port(DOUBLE, "Ignored", required=False),
    }
    OUTPUTS: ClassVar = {"collision_poses": output_port(POSES, "The poses after which the path is closed")}

    def setup(self, **kwargs: Any) -> None:
        """Query the lanes that are open now.

        Raises:
            SimulatorNotFound, SimulatorGone, Unreachable, RequestError, RequestTimeout: The simulator does not answer.
            PortError: A port's value in the file is invalid.
        """
        super().setup(**kwargs)
        self._lanes = OpenLanes(kwargs["client"])

    def update(self) -> Status:
        """Query the open lanes and check the path."""
        path: Path | None = self.read("path")
        if path is None or not path.poses:
            self.feedback_message = "there is no path"
            return Status.FAILURE
        try:
            self._lanes.look()
        except HmrsimError as error:
            self.feedback_message = str(error)
            return Status.FAILURE
        closed = self._lanes.closed_legs(path)
        reported = closed[:1] if self.read("stop_at_first_collision") else closed
        self.write("collision_poses", [path.poses[index] for index in reported])
        self.feedback_message = f"closed from pose {closed[0]} on" if closed else "open"
        return Status.FAILURE if closed else Status.SUCCESS


class ValidatePath(IsPathValid):
    """Succeeds if a path is open: same as ``IsPathValid``, under its name in newer trees."""


class IsWithinPathTrackingBounds(Condition):
    """Succeeds if the robot believes that it is near its path and faces along it; also before it follows one.

    The sign of a bound does not matter.
    """

    INPUTS: ClassVar = {
        "max_error_left": input_port(FINITE, "Largest distance to the left of the path", default=0.5),
        "max_error_right": input_port(FINITE, "Largest distance to the right of it", default=0.5),
        "max_error_heading": input_port(FINITE, "Largest angle to it, in radians", default=3.14),
        "tracking_feedback": input_port(TRACKING, "The feedback of FollowPath", required=False),
    }

    def update(self) -> Status:
        """Compare the errors with the bounds."""
        tracking: TrackingFeedback | None = self.read("tracking_feedback")
        if tracking is None:
            return Status.SUCCESS
        aside, turned = tracking.position_tracking_error, tracking.heading_tracking_error
        bound = self.read("max_error_left" if aside >= 0.0 else "max_error_right")
        if abs(aside) <= abs(bound) and abs(turned) <= abs(self.read("max_error_heading")):
            self.feedback_message = ""
            return Status.SUCCESS
        self.feedback_message = f"{aside:+.2f} left of its path, {turned:+.2f} rad to turn"
        return Status.FAILURE


Way = tuple[Point, Point]
"""A lane in its direction of travel."""


class OpenLanes:
    """The lanes that are open now, and those that were open earlier.

    Raises:
        SimulatorNotFound, SimulatorGone, Unreachable, RequestError, RequestTimeout: The simulator does not answer.
    """

    def __init__(self, client: Client) -> None:
        self._client = client
        self._received = b""
        self._open: frozenset[Way] = frozenset()
        self._known: frozenset[Way] = frozenset()
        self.look()

    def look(self) -> None:
        """Query the open lanes, and remember them.

        Raises:
            SimulatorNotFound, SimulatorGone, Unreachable, RequestError, RequestTimeout: The simulator does not answer.
        """
        received = self._client.get(self._client.keys.world("route_graph"))
        if received != self._received:
            self._received, self._open = received, _open_ways(received)
            self._known |= self._open

    def closed_legs(self, path: Path) -> list[int]:
        """Return the indices of the poses after which a path enters a closed lane."""
        closed = sorted(self._known - self._open)
        legs = [(point_of(a), point_of(b)) for a, b in pairwise(path.poses)]
        # The closed lane on which the path begins may be left; None after that.
        leaving = next((way for way in closed if legs and _is_on(legs[0], way) and not _is_begun(legs[0], way)), None)
        found = []
        for index, leg in enumerate(legs):
            if leaving is not None and not _is_on(leg, leaving):
                leaving = None
            if any(way != leaving and (_is_on(leg, way) or _is_on(way, leg)) for way in closed):
                found.append(index)
        return found


def _open_ways(received: bytes) -> frozenset[Way]:
    """Return the lanes of a route graph as it was received.

    Raises:
        UnreadableError: It is none.
    """
    graph = plain_values("the route graph", received)
    try:
        return frozenset(_ways(graph))
    except (LookupError, TypeError):
        raise UnreadableError("the route graph is not in Nav2's GeoJSON format") from None


def _ways(graph: Any) -> Iterator[Way]:
    """Yield the lanes of a route graph in Nav2's GeoJSON format."""
    for feature in graph["features"]:
        match feature["geometry"]:
            case {"type": "LineString", "coordinates": [first, *_, last]}:
                yield (first[0], first[1]), (last[0], last[1])
            case {"type": "MultiLineString", "coordinates": [[first, *_], *_] as lines}:
                yield (first[0], first[1]), (lines[-1][-1][0], lines[-1][-1][1])


def _is_on(leg: Way, way: Way) -> bool:
    """Return whether a leg lies on a straight lane in the same direction."""
    (a, b), (start, end) = leg, way
    along = (b[0] - a[0]) * (end[0] - start[0]) + (b[1] - a[1]) * (end[1] - start[1])
    return along > 0.0 and all(distance(point, foot(point, start, end)) <= SAME_PLACE for point in leg)


def _is_begun(leg: Way, way: Way) -> bool:
    """Return whether a leg begins at the begin of a lane."""
    return distance(leg[0], way[0]) <= SAME_PLACE


FAMILY = Family.of_module(__name__)
