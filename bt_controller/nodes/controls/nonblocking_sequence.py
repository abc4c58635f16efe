"""Nav2's NonblockingSequence: a RUNNING child does not block the following ones."""

from __future__ import annotations

from typing import TYPE_CHECKING

from py_trees.common import Status

from bt_controller.core.node import Control, Ticks
from bt_controller.nodes import Family

if TYPE_CHECKING:
    from collections.abc import Sequence

    from py_trees.behaviour import Behaviour


class NonblockingSequence(Control):
    """Ticks all its children at each tick, including those that have ended.

    Fails as soon as one fails, and halts the others; succeeds when all succeed in one tick; else it is RUNNING. If all
    children are skipped, so is the node.
    """

    def next_ticked(self) -> Sequence[Behaviour]:
        """Return all children."""
        return self.children if self.status is Status.RUNNING else ()

    def advance(self) -> Ticks:
        """Tick all children."""
        for child in self.children:
            yield from child.tick()
            if child.status is Status.FAILURE:
                return Status.FAILURE
        statuses = [child.status for child in self.children]
        if Status.RUNNING in statuses:
            return Status.RUNNING
        return Status.SUCCESS if Status.SUCCESS in statuses else Status.INVALID


FAMILY = Family("nonblocking_sequence", {"NonblockingSequence": NonblockingSequence})
