"""Nav2's check whether a path is still valid: a condition in older trees, an action in newer ones."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

from py_trees.common import Status

from bt_controller.core.node import Condition
from bt_controller.core.ports import BOOL, DOUBLE, INT, PATH, POSES, STRING, input_port, output_port
from bt_controller.nodes.open_lanes import OpenLanes
from hmrsim.errors import HmrsimError

if TYPE_CHECKING:
    from hmrsim.interfaces.nav_msgs import Path

_NO_COSTMAP = "Read and not needed: there is no costmap here"


class PathCheck(Condition):
    """Succeeds if a path is open, and fails if it is not or there is none; `IsPathValid` says what is open."""

    INPUTS: ClassVar = {
        "path": input_port(PATH, "The path", required=False),
        "stop_at_first_collision": input_port(BOOL, "Whether to give the first pose only", default=True),
        "max_cost": input_port(INT, _NO_COSTMAP, default=254),
        "consider_unknown_as_obstacle": input_port(BOOL, _NO_COSTMAP, default=False),
        "layer_name": input_port(STRING, _NO_COSTMAP, default=""),
        "footprint": input_port(STRING, "Read and not needed: footprints matter between robots only", default=""),
        "max_lookahead_distance": input_port(DOUBLE, "Read and not needed: all of the path is looked at", default=-1.0),
        "service_name": input_port(
            STRING, "Read and not needed: the simulator says which lanes are open", required=False
        ),
        "server_timeout": input_port(DOUBLE, "Milliseconds; read and not needed", required=False),
    }
    OUTPUTS: ClassVar = {"collision_poses": output_port(POSES, "The poses from which it is not open")}

    def setup(self, **kwargs: Any) -> None:
        """Look which lanes there are.

        Args:
            **kwargs: *client*, and the arguments of all nodes.

        Raises:
            NobodyThere, SimulatorGone, Unreachable, RequestError, RequestTimeout: The simulator does not answer.
            PortError: A port's value in the file is invalid.
        """
        super().setup(**kwargs)
        self._lanes = OpenLanes(kwargs["client"])

    def update(self) -> Status:
        """Look which lanes are open now."""
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
        told = closed[:1] if self.read("stop_at_first_collision") else closed
        self.write("collision_poses", [path.poses[index] for index in told])
        self.feedback_message = f"closed from pose {closed[0]} on" if closed else "open"
        return Status.FAILURE if closed else Status.SUCCESS
