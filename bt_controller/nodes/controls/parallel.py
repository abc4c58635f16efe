"""BehaviorTree.CPP's parallels, which tick all children in each tick."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar, Final

from py_trees.common import Status

from bt_controller.core.node import Control, PortError, Ticks
from bt_controller.core.ports import CHILDREN, input_port
from bt_controller.nodes import Family

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour

_OPEN: Final = (Status.RUNNING, Status.INVALID)


class _SideBySide(Control):
    """Ticks each child until it has ended."""

    def next_ticked(self) -> Sequence[Behaviour]:
        """Return the children that have not ended."""
        if self.status is not Status.RUNNING:
            return super().next_ticked()
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


FAMILY = Family.of("parallel", Parallel, ParallelAll)
