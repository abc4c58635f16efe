"""Nav2's actions that cancel all goals of an action of the robot, also those of other clients."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

from py_trees.common import Status

from bt_controller.core.action_node import ACTION_INPUTS
from bt_controller.core.node import Leaf
from bt_controller.nodes import Family
from bt_controller.world.directory import Directory
from hmrsim.actions import registry
from hmrsim.errors import HmrsimError

if TYPE_CHECKING:
    from hmrsim_zenoh.client.action_client import ActionClient


class _Cancel(Leaf):
    """Succeeds when the robot answers the cancel request, else fails. In lockstep it does not wait for the answer."""

    ACTION: ClassVar[str]
    """The name of the action."""

    INPUTS: ClassVar = ACTION_INPUTS

    def setup(self, **kwargs: Any) -> None:
        """Look the action up.

        Raises:
            NotServed: There is no such robot, or it has no such action.
            PortError: A port's value in the file is invalid.
        """
        super().setup(**kwargs)
        directory = kwargs.get("directory") or Directory.from_info(kwargs["client"].info())
        robot, action = directory.resolve(kwargs["robot"], self.read("server_name") or self.ACTION)
        self._client: ActionClient[Any, Any, Any] = kwargs["client"].action_client(robot, registry()[action])

    def update(self) -> Status:
        """Cancel all goals, including those that were sent in this tick."""
        try:
            self._client.cancel_all()
        except HmrsimError as error:
            self.feedback_message = str(error)
            return Status.FAILURE
        return Status.SUCCESS


class CancelBackUp(_Cancel):
    """Cancels `BackUp`."""

    ACTION = "back_up"


class CancelComputeAndTrackRoute(_Cancel):
    """Cancels `ComputeAndTrackRoute`."""

    ACTION = "compute_and_track_route"


class CancelControl(_Cancel):
    """Cancels `FollowPath`."""

    ACTION = "follow_path"


class CancelDriveOnHeading(_Cancel):
    """Cancels `DriveOnHeading`."""

    ACTION = "drive_on_heading"


class CancelSpin(_Cancel):
    """Cancels `Spin`."""

    ACTION = "spin"


class CancelWait(_Cancel):
    """Cancels `Wait`."""

    ACTION = "wait"


FAMILY = Family.of(
    "cancels",
    CancelBackUp,
    CancelComputeAndTrackRoute,
    CancelControl,
    CancelDriveOnHeading,
    CancelSpin,
    CancelWait,
)
