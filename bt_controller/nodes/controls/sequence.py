"""BehaviorTree.CPP's sequences: all children have to succeed, one after the other."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from py_trees.common import Status

from bt_controller.nodes import Family
from bt_controller.nodes.controls._in_order import InOrder, Reactive

if TYPE_CHECKING:
    from bt_controller.core.node import Ticks


class Sequence(InOrder):
    """Ticks its children in order; succeeds if all succeed. Fails with the first that fails, and then starts over.

    A RUNNING child is ticked again, earlier ones are not. Skipped children are ignored; if all are skipped, so is the
    sequence.
    """

    passes = Status.SUCCESS


class AsyncSequence(Sequence):
    """Same as ``Sequence``: BehaviorTree.CPP yields between two children, but here a tick takes no time."""


class SequenceWithMemory(Sequence):
    """A ``Sequence`` that does not tick succeeded children again: after a failure it begins with the failed child.

    After a halt it continues with the same child. When all children have succeeded it starts over.
    """

    def initialise(self) -> None:
        """Continue with the current child."""
        self._counts = self._turn > 0

    def advance(self) -> Ticks:
        """Tick the current child and the following ones."""
        status = yield from super().advance()
        if self._turn == len(self.children):
            self._turn = 0
        return status

    def _reset_children(self) -> None:
        for child in self.children[self._turn :]:
            self.reset(child)


class ReactiveSequence(Reactive):
    """Ticks its children from the first at each tick; succeeds if all succeed. Fails with the first failure.

    So conditions are evaluated again at each tick. When a child is RUNNING or fails, the following ones are halted.
    Skipped children are ignored; if all are skipped, so is the sequence.
    """

    passes: ClassVar = Status.SUCCESS


FAMILY = Family.of("sequence", Sequence, AsyncSequence, SequenceWithMemory, ReactiveSequence)
