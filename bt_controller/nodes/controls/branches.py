"""BehaviorTree.CPP's IfThenElse and WhileDoElse: a condition and its branches."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from py_trees.common import Status

from bt_controller.core.node import Control, Ticks
from bt_controller.nodes import Family

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour


class IfThenElse(Control):
    """Ticks its second child if the first succeeds, its third if the first fails, and returns that child's status.

    The first child is not ticked again while another is RUNNING. Without a third child the node fails if the first
    does. If the first child is skipped, so is the node.
    """

    least, most = 2, 3

    def initialise(self) -> None:
        """Begin with the condition."""
        self._branch = 0

    def advance(self) -> Ticks:
        """Tick the condition or the branch."""
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
    """Ticks its second child while the first succeeds, its third while the first fails, and returns its status.

    The first child is ticked at each tick; when its status changes, the other branch is halted. While it is RUNNING,
    no branch is ticked. Without a third child the node fails if the first does. If the first child is skipped, so is
    the node.
    """

    least, most = 2, 3

    def next_ticked(self) -> Sequence[Behaviour]:
        """Return the condition and the RUNNING branch."""
        condition, *branches = self.children
        running = [branch for branch in branches if branch.status is Status.RUNNING]
        return [condition, *running] if running else super().next_ticked()

    def advance(self) -> Ticks:
        """Tick the condition and the branch."""
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


FAMILY = Family.of("branches", IfThenElse, WhileDoElse)
