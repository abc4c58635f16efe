"""Nav2's sequences: NonblockingSequence, PersistentSequence, PipelineSequence."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

from py_trees.blackboard import Blackboard
from py_trees.common import Status

from bt_controller.core.node import Control, Ticks
from bt_controller.core.ports import INT, input_port
from bt_controller.nodes import Family

if TYPE_CHECKING:
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


class PersistentSequence(Control):
    """A sequence that continues with the child ``current_child_idx``, even after it was halted.

    A child that succeeds or is skipped is followed by the next one. When one fails, or all have been ticked, the index
    is reset to 0.
    """

    INPUTS: ClassVar = {
        "current_child_idx": input_port(INT, "Index of the current child, from 0; also written", default=0)
    }

    def advance(self) -> Ticks:
        """Tick the children from the current one."""
        index = self.read("current_child_idx")
        while index < len(self.children):
            child = self.children[index]
            yield from child.tick()
            if child.status is Status.RUNNING:
                return Status.RUNNING
            if child.status is Status.FAILURE:
                self._note(0)
                return Status.FAILURE
            index += 1
            self._note(index)
        self._note(0)
        return Status.SUCCESS

    def _note(self, index: int) -> None:
        """Write to the input port: ports of py_trees have one direction only."""
        Blackboard.set(self._get_blackboard_key("current_child_idx"), index)


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


FAMILY = Family.of("nav2_sequences", NonblockingSequence, PersistentSequence, PipelineSequence)
