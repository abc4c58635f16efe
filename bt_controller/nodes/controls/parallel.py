"""BehaviorTree.CPP's parallels: all children at once, as far as a tree can."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, Final

from py_trees.common import Status

from bt_controller.core.node import Control, PortError
from bt_controller.core.ports import CHILDREN, input_port
from bt_controller.nodes import Family

if TYPE_CHECKING:
    from collections.abc import Generator, Sequence

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
        """Return how many children a port means; -1 means all, -2 all but one.

        Raises:
            PortError: There are not so many.
        """
        number: int = self.read(port)
        meant = number if number >= 0 else max(len(self.children) + number + 1, 0)
        if meant > len(self.children):
            raise PortError(f"{self._whose(port)}: {number} of {len(self.children)} children is never reached")
        return meant


class Parallel(_SideBySide):
    """Ticks all children that have not ended, each tick; succeeds and fails when as many of them have.

    A negative number counts from the end: -1 is all of them. It fails, too, when it can't succeed any more. The
    others are halted then. A skipped child is ticked again, and beside a negative *success_count* counts as a
    success; if all are skipped, so is the node.
    """

    INPUTS: ClassVar = {
        "success_count": input_port(CHILDREN, "How many children have to succeed; -1 is all", default=-1),
        "failure_count": input_port(CHILDREN, "How many children have to fail; -1 is all", default=1),
    }

    def advance(self) -> Generator[Behaviour, None, Status]:
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
    """Ticks all children until each has ended; fails if at least *max_failures* of them have, and succeeds otherwise.

    A negative number counts from the end: -1 is all of them. Skipped children are not waited for; if all are
    skipped, so is the node.
    """

    INPUTS: ClassVar = {
        "max_failures": input_port(CHILDREN, "From how many failures on it fails; -1 is all", default=1)
    }

    def advance(self) -> Generator[Behaviour, None, Status]:
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


FAMILY = Family("parallel", {"Parallel": Parallel, "ParallelAll": ParallelAll})
