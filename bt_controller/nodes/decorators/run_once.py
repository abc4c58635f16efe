"""BehaviorTree.CPP's RunOnce: a child that is executed once."""

from __future__ import annotations

from typing import ClassVar

from py_trees.common import Status

from bt_controller.core.node import Decoration, Ticks
from bt_controller.core.ports import BOOL, input_port
from bt_controller.nodes import Family


class RunOnce(Decoration):
    """Ticks its child until it has ended once, and returns its status; after that the child is not ticked any more.

    With *then_skip*, the default, the node is then skipped; otherwise it returns the child's last status. A child that
    is halted or skipped has not ended.
    """

    INPUTS: ClassVar = {"then_skip": input_port(BOOL, "Whether the node is skipped afterwards", default=True)}

    _outcome: Status | None = None

    def advance(self) -> Ticks:
        """Tick the child unless it has ended before."""
        if self._outcome is not None:
            return Status.INVALID if self.read("then_skip") else self._outcome
        status = yield from self.tick_child()
        if status in (Status.SUCCESS, Status.FAILURE):
            self._outcome = status
        return status


FAMILY = Family("run_once", {"RunOnce": RunOnce})
