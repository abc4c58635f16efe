"""Nav2's IsPathValid, which newer trees call ValidatePath."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

from py_trees.common import Status

from bt_controller.core.node import Condition
from bt_controller.core.ports import BOOL, DOUBLE, INT, PATH, POSES, STRING, input_port, output_port
from bt_controller.nodes import Family
from bt_controller.nodes.open_lanes import OpenLanes
from hmrsim.errors import HmrsimError

if TYPE_CHECKING:
    from hmrsim.interfaces.nav_msgs import Path

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
        """Query the lanes.

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


FAMILY = Family.of("path_validity", IsPathValid, ValidatePath)
