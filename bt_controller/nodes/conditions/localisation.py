"""Nav2's conditions on localisation: a simulated robot is always localized."""

from __future__ import annotations

from typing import ClassVar, Final

from py_trees.common import Status

from bt_controller.core.node import Leaf
from bt_controller.core.ports import BOOL, STRING, input_port
from bt_controller.nodes import Family

_FRAMES: Final = ("map", "base_link")


class InitialPoseReceived(Leaf):
    """Succeeds unless the file sets the port to false: simulated robots are localized from the start."""

    INPUTS: ClassVar = {"initial_pose_received": input_port(BOOL, "Whether there is a pose", default=True)}

    def update(self) -> Status:
        """Return the port's value as a status."""
        return Status.SUCCESS if self.read("initial_pose_received") else Status.FAILURE


class TransformAvailable(Leaf):
    """Succeeds if both frames are known: ``map`` and ``base_link`` are, and no others."""

    INPUTS: ClassVar = {"child": input_port(STRING, "One frame"), "parent": input_port(STRING, "The other")}

    def update(self) -> Status:
        """Check the frames."""
        unknown = [frame for frame in map(self.read, self.INPUTS) if frame not in _FRAMES]
        if unknown:
            self.feedback_message = f"no frame {unknown[0]!r}; there are {' and '.join(_FRAMES)}"
            return Status.FAILURE
        return Status.SUCCESS


FAMILY = Family.of("localisation", InitialPoseReceived, TransformAvailable)
