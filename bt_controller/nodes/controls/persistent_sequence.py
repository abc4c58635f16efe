"""Nav2's PersistentSequence: a sequence that keeps its current child on the blackboard."""

from __future__ import annotations

from typing import ClassVar

from py_trees.blackboard import Blackboard
from py_trees.common import Status

from bt_controller.core.node import Control, Ticks
from bt_controller.core.ports import INT, input_port
from bt_controller.nodes import Family


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


FAMILY = Family("persistent_sequence", {"PersistentSequence": PersistentSequence})
