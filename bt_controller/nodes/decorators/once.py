"""Decorators whose child is executed once: BehaviorTree.CPP's RunOnce, Nav2's SingleTrigger."""

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


class SingleTrigger(Decoration):
    """Ticks its child until it has ended, and returns its status; after that it fails until it is reset.

    With ``is_global`` a reset has no effect: the node fails until the end of the tree.
    """

    INPUTS: ClassVar = {"is_global": input_port(BOOL, "Whether a reset has no effect", default=False)}

    _triggered = False

    def initialise(self) -> None:
        """Reset the trigger, if the node is idle."""
        if self.status is Status.INVALID and not self.read("is_global"):
            self._triggered = False

    def advance(self) -> Ticks:
        """Tick the child unless it has ended before."""
        if self._triggered:
            return Status.FAILURE
        status = yield from self.tick_child()
        self._triggered = status in (Status.SUCCESS, Status.FAILURE)
        return status


FAMILY = Family.of("once", RunOnce, SingleTrigger)
