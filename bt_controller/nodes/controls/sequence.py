"""BehaviorTree.CPP's sequences: all children have to succeed, one after the other."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from py_trees.common import Status

from bt_controller.nodes import Family
from bt_controller.nodes.controls._in_order import InOrder, Reactive

if TYPE_CHECKING:
    from collections.abc import Generator

    from py_trees.behaviour import Behaviour


class Sequence(InOrder):
    """Succeeds when all children have, one after the other. Fails with the first that does, and begins anew then.

    A child that runs is ticked again, those before it are not. Skipped children are passed over; if all are
    skipped, so is the sequence.
    """

    passes = Status.SUCCESS


class AsyncSequence(Sequence):
    """Is a ``Sequence``: in BehaviorTree.CPP the others have a look between two children, here a tick is an instant."""


class SequenceWithMemory(Sequence):
    """Is a ``Sequence`` that does not tick again what has succeeded: after a failure it begins with the failed child.

    Also after it was halted it goes on where it was. When all children have succeeded it begins anew.
    """

    def initialise(self) -> None:
        """Begin where it was."""
        self._counts = self._turn > 0

    def advance(self) -> Generator[Behaviour, None, Status]:
        """Tick the current child, and those after it."""
        status = yield from super().advance()
        if self._turn == len(self.children):
            self._turn = 0
        return status

    def _reset_children(self) -> None:
        for child in self.children[self._turn :]:
            self.reset(child)


class ReactiveSequence(Reactive):
    """Succeeds when all children have, in one tick. Fails with the first that does.

    At each tick it begins with the first child, so that conditions are looked at again. When a child runs or fails
    those after it are halted. Skipped children are passed over; if all are skipped, so is the sequence.
    """

    passes: ClassVar = Status.SUCCESS


FAMILY = Family(
    "sequence",
    {node.__name__: node for node in (Sequence, AsyncSequence, SequenceWithMemory, ReactiveSequence)},
)
