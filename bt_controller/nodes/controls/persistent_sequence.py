"""Nav2's PersistentSequence: which child's turn it is stands on the blackboard."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from py_trees.blackboard import Blackboard
from py_trees.common import Status

from bt_controller.core.node import Control
from bt_controller.core.ports import INT, input_port
from bt_controller.nodes import Family

if TYPE_CHECKING:
    from collections.abc import Generator

    from py_trees.behaviour import Behaviour


class PersistentSequence(Control):
    """A sequence that goes on where it was, also after it was halted: ``current_child_idx`` says with which child.

    A child that has succeeded or was skipped is followed by the next one. When one has failed, or all have been
    ticked, the index is 0 again.
    """

    INPUTS: ClassVar = {
        "current_child_idx": input_port(INT, "Which child's turn it is, from 0; written, too", default=0)
    }

    def advance(self) -> Generator[Behaviour, None, Status]:
        """Tick the children from the one whose turn it is."""
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
        """Write to the port that is read: py_trees knows ports of one direction only."""
        Blackboard.set(self._get_blackboard_key("current_child_idx"), index)


FAMILY = Family("persistent_sequence", {"PersistentSequence": PersistentSequence})
