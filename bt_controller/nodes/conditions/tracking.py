"""Nav2's condition on how a robot keeps to its path."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from py_trees.common import Status

from bt_controller.core.node import Condition
from bt_controller.core.ports import FINITE, TRACKING, input_port
from bt_controller.nodes import Family

if TYPE_CHECKING:
    from hmrsim.interfaces.nav2_msgs import TrackingFeedback


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


FAMILY = Family.of("tracking", IsWithinPathTrackingBounds)
