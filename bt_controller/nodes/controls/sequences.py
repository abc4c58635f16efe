"""BehaviorTree.CPP's sequences, where all children have to succeed, fallbacks, where one has to, and parallels."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, Final

from py_trees.common import Status

from bt_controller.core.node import Control, PortError, Ticks
from bt_controller.core.ports import CHILDREN, input_port
from bt_controller.nodes import Family

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour


class _InOrder(Control):
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


class _Reactive(Control):
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


class Sequence(_InOrder):
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


class ReactiveSequence(_Reactive):
    """Ticks its children from the first at each tick; succeeds if all succeed. Fails with the first failure.

    So conditions are evaluated again at each tick. When a child is RUNNING or fails, the following ones are halted.
    Skipped children are ignored; if all are skipped, the sequence is skipped.
    """

    passes: ClassVar = Status.SUCCESS


class Fallback(_InOrder):
    """Ticks its children in order until one succeeds; fails if all fail.

    A RUNNING child is ticked again, earlier ones are not. Skipped children are ignored; if all are skipped, the
    fallback is skipped.
    """

    passes = Status.FAILURE


class AsyncFallback(Fallback):
    """Same as ``Fallback``: BehaviorTree.CPP yields between two children, but here a tick takes no time."""


class ReactiveFallback(_Reactive):
    """Ticks its children from the first at each tick until one succeeds; fails if all fail in one tick.

    So conditions are evaluated again at each tick. When a child is RUNNING or succeeds, the following ones are halted.
    Skipped children are ignored; if all are skipped, the fallback is skipped.
    """

    passes: ClassVar = Status.FAILURE


_OPEN: Final = (Status.RUNNING, Status.INVALID)


class _SideBySide(Control):
    """Ticks each child until it has ended."""

    def next_ticked(self) -> list[Behaviour]:
        """Return the children that have not ended."""
        if self.status is not Status.RUNNING:
            return [*super().next_ticked()]
        return [child for child in self.children if child.status in _OPEN]

    def _count(self, status: Status) -> int:
        return [child.status for child in self.children].count(status)

    def _threshold(self, port: str) -> int:
        """Return the threshold of a port; -1 stands for all children, -2 for all but one.

        Raises:
            PortError: There are fewer children.
        """
        number: int = self.read(port)
        meant = number if number >= 0 else max(len(self.children) + number + 1, 0)
        if meant > len(self.children):
            raise PortError(f"{self._whose(port)}: {number} of {len(self.children)} children is never reached")
        return meant


class Parallel(_SideBySide):
    """Ticks all children that have not ended; succeeds or fails when the number of successes or failures is reached.

    Negative numbers count from the end: -1 stands for all children. The node also fails when it can't succeed any
    more. The remaining children are then halted. A skipped child is ticked again, and counts as a success if
    *success_count* is negative; if all children are skipped, the node is skipped.
    """

    INPUTS: ClassVar = {
        "success_count": input_port(CHILDREN, "Number of children that have to succeed; -1 for all", default=-1),
        "failure_count": input_port(CHILDREN, "Number of children that have to fail; -1 for all", default=1),
    }

    def advance(self) -> Ticks:
        """Tick the children until enough have ended."""
        needed, fatal = self._threshold("success_count"), self._threshold("failure_count")
        forgiving = self.read("success_count") < 0
        skipped = 0
        for child in self.children:
            if child.status in _OPEN:
                yield from child.tick()
                skipped += child.status is Status.INVALID
            successes, failures = self._count(Status.SUCCESS), self._count(Status.FAILURE)
            if skipped == len(self.children):
                return Status.INVALID
            if successes + (skipped if forgiving else 0) >= needed:
                return Status.SUCCESS
            if failures >= fatal or len(self.children) - failures < needed:
                return Status.FAILURE
        return Status.RUNNING


class ParallelAll(_SideBySide):
    """Ticks all children until each has ended; fails if at least *max_failures* of them failed, and succeeds otherwise.

    Negative numbers count from the end: -1 stands for all children. The node does not wait for skipped children; if
    all are skipped, the node is skipped.
    """

    INPUTS: ClassVar = {
        "max_failures": input_port(CHILDREN, "Number of failures with which the node fails; -1 for all", default=1)
    }

    def advance(self) -> Ticks:
        """Tick the children that have not ended."""
        fatal = self._threshold("max_failures")
        for child in self.children:
            if child.status in _OPEN:
                yield from child.tick()
        if self._count(Status.RUNNING):
            return Status.RUNNING
        if self._count(Status.INVALID) == len(self.children):
            return Status.INVALID
        return Status.FAILURE if self._count(Status.FAILURE) >= fatal else Status.SUCCESS


FAMILY = Family.of_module(__name__)
