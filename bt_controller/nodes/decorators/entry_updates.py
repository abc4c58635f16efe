"""BehaviorTree.CPP's SkipUnlessUpdated and WaitValueUpdate: a child for each new value of an entry."""

from __future__ import annotations

from typing import ClassVar

from py_trees.common import Status

from bt_controller.core.node import EACH_PERIOD, Decoration, Ticks
from bt_controller.core.ports import ANY, input_port
from bt_controller.nodes import Family
from bt_controller.nodes.entry_updates import Watching


class SkipUnlessUpdated(Watching, Decoration):
    """Ticks its child if an entry was written since the last check, and returns the child's status.

    Otherwise it is skipped. The entry is not checked while the child is RUNNING; a halt does not count as a check.
    """

    INPUTS: ClassVar = {"entry": input_port(ANY, "Key of the entry, with or without braces")}
    otherwise: ClassVar = Status.INVALID

    def next_tick_time(self) -> float:
        """Return that the entry has to be polled."""
        return super().next_tick_time() if self.child.status is Status.RUNNING else EACH_PERIOD

    def advance(self) -> Ticks:
        """Check the entry, or tick the RUNNING child."""
        if self.child.status is not Status.RUNNING and not self.updated():
            return self.otherwise
        return (yield from self.tick_child())


class WaitValueUpdate(SkipUnlessUpdated):
    """Ticks its child if an entry was written since the last check, and returns the child's status.

    Otherwise it is RUNNING. The entry is not checked while the child is RUNNING; a halt does not count as a check.
    """

    otherwise = Status.RUNNING


FAMILY = Family.of("entry_updates", SkipUnlessUpdated, WaitValueUpdate)
