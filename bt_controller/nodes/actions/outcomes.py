"""BehaviorTree.CPP's AlwaysSuccess and AlwaysFailure."""

from __future__ import annotations

from py_trees.common import Status

from bt_controller.core.node import Leaf
from bt_controller.nodes import Family


class AlwaysSuccess(Leaf):
    """Succeeds."""

    def update(self) -> Status:
        """Return the status."""
        return Status.SUCCESS


class AlwaysFailure(Leaf):
    """Fails."""

    def update(self) -> Status:
        """Return the status."""
        return Status.FAILURE


FAMILY = Family.of("outcomes", AlwaysSuccess, AlwaysFailure)
