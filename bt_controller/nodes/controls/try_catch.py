"""BehaviorTree.CPP's TryCatch: clean up after a failure."""

from __future__ import annotations

from typing import ClassVar

from py_trees.common import Status

from bt_controller.core.node import Control, Ticks
from bt_controller.core.ports import BOOL, input_port
from bt_controller.nodes import Family


class TryCatch(Control):
    """Ticks all children except the last as a sequence. When one of them fails, ticks the last one, and then fails.

    The node fails whatever the status of the last child. Skipped children are ignored; if all except the last are
    skipped, so is the node. With *catch_on_halt* the last child is also ticked once if the node is halted.
    """

    INPUTS: ClassVar = {"catch_on_halt": input_port(BOOL, "Whether a halt counts as a failure", default=False)}
    least = 2

    def initialise(self) -> None:
        """Begin with the first child."""
        self._turn = 0
        self._counts = self._catches = False

    def advance(self) -> Ticks:
        """Tick the current child and the following ones."""
        *tried, catch = self.children
        while self._turn < len(tried) and not self._catches:
            child = tried[self._turn]
            yield from child.tick()
            if child.status is Status.RUNNING:
                return Status.RUNNING
            if child.status is Status.FAILURE:
                self._catches = True
            else:
                self._counts = self._counts or child.status is Status.SUCCESS
                self._turn += 1
        if not self._catches:
            return Status.SUCCESS if self._counts else Status.INVALID
        yield from catch.tick()
        return Status.RUNNING if catch.status is Status.RUNNING else Status.FAILURE

    def terminate(self, new_status: Status) -> None:
        """Tick the last child upon a halt, with *catch_on_halt*, and halt it."""
        halted = new_status is Status.INVALID and self.status is Status.RUNNING
        if halted and not self._catches and self._turn < len(self.children) - 1 and self.read("catch_on_halt"):
            catch = self.children[-1]
            catch.tick_once()
            self.reset(catch)


FAMILY = Family.of("try_catch", TryCatch)
