"""Nav2's RoundRobin: another child each time."""

from __future__ import annotations

from typing import ClassVar

from py_trees.common import Status

from bt_controller.core.node import Control, Ticks
from bt_controller.core.ports import BOOL, input_port
from bt_controller.nodes import Family


class RoundRobin(Control):
    """Ticks its children in order until one succeeds; the next time it continues with the child after that.

    Fails when all children have failed in a row. The first child follows the last one only with ``wrap_around``:
    otherwise the node fails once after the last child, and then begins with the first. If all children are skipped, so
    is the node. After a halt it begins with the first child.

    This is the documented behavior; Nav2's implementation fails when the last child has ended, whatever its status.
    """

    INPUTS: ClassVar = {"wrap_around": input_port(BOOL, "Whether the first child follows the last one", default=False)}

    _next = 0
    """The index of the current child."""
    _failed = 0
    """The number of consecutive failures."""

    def advance(self) -> Ticks:
        """Tick the children from the current one."""
        count, skipped = len(self.children), 0
        while self._next < count and self._failed + skipped < count:
            child = self.children[self._next]
            yield from child.tick()
            if child.status is Status.RUNNING:
                return Status.RUNNING
            self._next += 1
            if self.read("wrap_around"):
                self._next %= count
            match child.status:
                case Status.SUCCESS:
                    self._failed = 0
                    return Status.SUCCESS
                case Status.FAILURE:
                    self._failed += 1
                case _:
                    skipped += 1
        self._next = self._failed = 0
        return Status.INVALID if skipped == count else Status.FAILURE

    def terminate(self, new_status: Status) -> None:
        """Begin with the first child if the node is halted; a reset after its end changes nothing."""
        if new_status is Status.INVALID and self.status is Status.RUNNING:
            self._next = self._failed = 0


FAMILY = Family.of("round_robin", RoundRobin)
