"""Nav2's SingleTrigger: a child that is executed once."""

from __future__ import annotations

from typing import ClassVar

from py_trees.common import Status

from bt_controller.core.node import Decoration, Ticks
from bt_controller.core.ports import BOOL, input_port
from bt_controller.nodes import Family


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


FAMILY = Family("single_trigger", {"SingleTrigger": SingleTrigger})
