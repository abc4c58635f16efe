"""The robot's detections: on the blackboard, and as a condition."""

from __future__ import annotations

from typing import TYPE_CHECKING

from py_trees.common import Status

from bt_controller.behaviours import subscribers

if TYPE_CHECKING:
    from hmrsim.interfaces.vision_msgs import Detection3D, Detection3DArray


class ToBlackboard(subscribers.ToBlackboard):
    """Writes the latest ``detections``, a Detection3DArray, on the blackboard.

    Args:
        robot: The robot; None for the one that the tree is run for.
    """

    def __init__(
        self, name: str = "Detections to blackboard", *, key: str = "detections", robot: str | None = None
    ) -> None:
        super().__init__(name, "detections", key, robot=robot)


class IsDetected(subscribers.Handler):
    """Succeeds while the robot's sensors detect an entity; fails while they don't.

    Args:
        entity: The entity's name, or its class.
        name: The behavior's name; names the entity if left out.
        robot: The robot; None for the one that the tree is run for.
    """

    def __init__(self, entity: str, *, name: str | None = None, robot: str | None = None) -> None:
        super().__init__(name or f"Is {entity} detected", "detections", robot=robot)
        self._entity = entity

    def update(self) -> Status:
        """Return whether the entity is detected."""
        seen: Detection3DArray = self.message()
        if any(self._entity in _names(detection) for detection in seen.detections):
            self.feedback_message = "detected"
            return Status.SUCCESS
        self.feedback_message = "not detected"
        return Status.FAILURE


def _names(detection: Detection3D) -> tuple[str, ...]:
    return detection.id, *(result.hypothesis.class_id for result in detection.results)
