"""BehaviorTree.CPP's IfThenElse and WhileDoElse: a condition, and what to do."""

from __future__ import annotations

from typing import TYPE_CHECKING

from py_trees.common import Status

from bt_controller.core.node import Control
from bt_controller.nodes import Family

if TYPE_CHECKING:
    from collections.abc import Generator, Sequence

    from py_trees.behaviour import Behaviour


class IfThenElse(Control):
    """Ticks its second child if the first succeeds and its third if that fails, and ends as they do.

    The first child is not ticked again while the other runs. Without a third child it fails when the first does;
    where the first is skipped, so is the node.
    """

    least, most = 2, 3

    def initialise(self) -> None:
        """Begin with the condition."""
        self._branch = 0

    def advance(self) -> Generator[Behaviour, None, Status]:
        """Tick the condition, or what follows from it."""
        if self._branch == 0:
            condition = self.children[0]
            yield from condition.tick()
            if condition.status in (Status.RUNNING, Status.INVALID):
                return condition.status
            self._branch = 1 if condition.status is Status.SUCCESS else 2
        if self._branch == len(self.children):
            return Status.FAILURE
        branch = self.children[self._branch]
        yield from branch.tick()
        return branch.status


class WhileDoElse(Control):
    """Ticks its second child while the first succeeds and its third while that fails, and ends as they do.

    The first child is ticked at each tick; the child that is no longer meant is halted. While the first runs the
    others wait. Without a third child it fails when the first does; where the first is skipped, so is the node.
    """

    least, most = 2, 3

    def next_ticked(self) -> Sequence[Behaviour]:
        """Return the condition, and what runs."""
        condition, *branches = self.children
        running = [branch for branch in branches if branch.status is Status.RUNNING]
        return [condition, *running] if running else super().next_ticked()

    def advance(self) -> Generator[Behaviour, None, Status]:
        """Tick the condition, and what follows from it."""
        condition, *branches = self.children
        yield from condition.tick()
        if condition.status in (Status.RUNNING, Status.INVALID):
            return condition.status
        meant = 0 if condition.status is Status.SUCCESS else 1
        for branch in branches[1 - meant : 2 - meant]:
            self.reset(branch)
        if meant == len(branches):
            return Status.FAILURE
        yield from branches[meant].tick()
        return branches[meant].status


FAMILY = Family("branches", {"IfThenElse": IfThenElse, "WhileDoElse": WhileDoElse})
