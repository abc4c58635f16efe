"""Nav2's PipelineSequence: children are ticked again while the following ones run."""

from __future__ import annotations

from typing import TYPE_CHECKING

from py_trees.common import Status

from bt_controller.core.node import Control, Ticks
from bt_controller.nodes import Family

if TYPE_CHECKING:
    from collections.abc import Sequence

    from py_trees.behaviour import Behaviour


class PipelineSequence(Control):
    """Ticks its children in order, up to the last one that was reached, including those that have ended.

    A RUNNING child does not block the following ones if one of them was reached before. Fails when a child fails;
    succeeds when the last child does and none before it has failed. If all children are skipped, so is the node.
    """

    def initialise(self) -> None:
        """Begin with no child reached."""
        self._reached = 0

    def next_ticked(self) -> Sequence[Behaviour]:
        """Return the children up to the last one that was reached."""
        return self.children[: self._reached + 1] if self.status is Status.RUNNING else ()

    def advance(self) -> Ticks:
        """Tick the children up to the first RUNNING one after those that were reached before."""
        skipped = 0
        for index, child in enumerate(self.children):
            yield from child.tick()
            match child.status:
                case Status.FAILURE:
                    return Status.FAILURE
                case Status.RUNNING if index >= self._reached:
                    self._reached = index
                    return Status.RUNNING
                case Status.INVALID:
                    skipped += 1
        return Status.INVALID if skipped == len(self.children) else Status.SUCCESS


FAMILY = Family("pipeline_sequence", {"PipelineSequence": PipelineSequence})
