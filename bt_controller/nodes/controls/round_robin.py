"""Nav2's RoundRobin: another child each time."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from py_trees.common import Status

from bt_controller.core.node import Control
from bt_controller.core.ports import BOOL, input_port
from bt_controller.nodes import Family

if TYPE_CHECKING:
    from collections.abc import Generator

    from py_trees.behaviour import Behaviour


class RoundRobin(Control):
    """Ticks one child after the other until one succeeds; the next time it goes on with the one after that.

    Fails when all children have failed in a row. After the last child comes the first one only with ``wrap_around``:
    without it the node fails once when all its turns are over, and then begins with the first child. Skipped if all
    its children are. Halted, it begins with the first child again.

    Nav2's own fails already with the end of the last child, whatever that is; its documentation has it as it is here.
    """

    INPUTS: ClassVar = {
        "wrap_around": input_port(BOOL, "Whether the first child comes after the last one", default=False)
    }

    _next = 0
    """Whose turn it is."""
    _failed = 0
    """How many have failed in a row."""

    def advance(self) -> Generator[Behaviour, None, Status]:
        """Tick the children from the one whose turn it is."""
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
        """Begin with the first child if the node is halted; one that has ended and is reset keeps its turn."""
        if new_status is Status.INVALID and self.status is Status.RUNNING:
            self._next = self._failed = 0


FAMILY = Family("round_robin", {"RoundRobin": RoundRobin})
