"""BehaviorTree.CPP's sequences, where all children have to succeed, and fallbacks, where one has to."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from py_trees.common import Status

from bt_controller.core.node import Control, Ticks
from bt_controller.nodes import Family

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour

    from bt_controller.core.node import Ticks


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

    def next_ticked(self) -> list[Behaviour]:
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


class Sequence(InOrder):
    """Ticks its children in order; succeeds if all succeed. Fails with the first that fails, and then starts over.

    A RUNNING child is ticked again, earlier ones are not. Skipped children are ignored; if all are skipped, the
    sequence is skipped.
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
    Skipped children are ignored; if all are skipped, the sequence is skipped.
    """

    passes: ClassVar = Status.SUCCESS


class Fallback(InOrder):
    """Ticks its children in order until one succeeds; fails if all fail.

    A RUNNING child is ticked again, earlier ones are not. Skipped children are ignored; if all are skipped, the
    fallback is skipped.
    """

    passes = Status.FAILURE


class AsyncFallback(Fallback):
    """Same as ``Fallback``: BehaviorTree.CPP yields between two children, but here a tick takes no time."""


class ReactiveFallback(Reactive):
    """Ticks its children from the first at each tick until one succeeds; fails if all fail in one tick.

    So conditions are evaluated again at each tick. When a child is RUNNING or succeeds, the following ones are halted.
    Skipped children are ignored; if all are skipped, the fallback is skipped.
    """

    passes: ClassVar = Status.FAILURE


FAMILY = Family.of(
    "sequences",
    Sequence,
    AsyncSequence,
    SequenceWithMemory,
    ReactiveSequence,
    Fallback,
    AsyncFallback,
    ReactiveFallback,
)
