"""The bases of sequences and fallbacks, which continue after one status of a child and end with the other."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

from py_trees.common import Status

from bt_controller.core.node import Control, Ticks

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour


class InOrder(Control):
    """Ticks its children in order; a RUNNING child is ticked again, earlier ones are not.

    Attributes:
        passes: The status of a child after which the next is ticked; after the last, the node's status.
    """

    passes: ClassVar[Status]

    _turn = 0
    _counts = False

    def initialise(self) -> None:
        """Begin with the first child."""
        self._turn, self._counts = 0, False

    def advance(self) -> Ticks:
        """Tick the current child and the following ones."""
        while self._turn < len(self.children):
            child = self.children[self._turn]
            yield from child.tick()
            if child.status not in (self.passes, Status.INVALID):
                return child.status
            self._counts = self._counts or child.status is self.passes
            self._turn += 1
        return self.passes if self._counts else Status.INVALID


class Reactive(Control):
    """Ticks its children from the first at each tick; the first that does not pass ends the tick and halts the others.

    Attributes:
        passes: The status of a child after which the next is ticked; after the last, the node's status.
    """

    passes: ClassVar[Status]

    def next_ticked(self) -> Sequence[Behaviour]:
        """Return the children up to the RUNNING one."""
        running = [index for index, child in enumerate(self.children) if child.status is Status.RUNNING]
        return self.children[: running[0] + 1] if running else []

    def advance(self) -> Ticks:
        """Tick the children until one does not pass."""
        counts = False
        for index, child in enumerate(self.children):
            if child.status is not Status.RUNNING:
                self.reset(child)
            yield from child.tick()
            if child.status not in (self.passes, Status.INVALID):
                for other in self.children[index + 1 :]:
                    self.reset(other)
                return child.status
            counts = counts or child.status is self.passes
        return self.passes if counts else Status.INVALID
