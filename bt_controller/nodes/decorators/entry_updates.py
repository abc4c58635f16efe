"""BehaviorTree.CPP's SkipUnlessUpdated and WaitValueUpdate: a child for each new value of an entry."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from py_trees.common import Status

from bt_controller.core.node import EACH_PERIOD, Decoration
from bt_controller.core.ports import ANY, input_port
from bt_controller.nodes import Family
from bt_controller.nodes.entry_updates import Watching

if TYPE_CHECKING:
    from collections.abc import Generator

    from py_trees.behaviour import Behaviour


class SkipUnlessUpdated(Watching, Decoration):
    """Ticks its child if an entry has been written since it was ticked before, and ends as the child does.

    Otherwise it is skipped. While the child runs the entry is not looked at; a halt does not count as a look.
    """

    INPUTS: ClassVar = {"entry": input_port(ANY, "Key of the entry, with or without braces")}
    otherwise: ClassVar = Status.INVALID

    def next_tick_time(self) -> float:
        """Return that the entry has to be polled."""
        return super().next_tick_time() if self.child.status is Status.RUNNING else EACH_PERIOD

    def advance(self) -> Generator[Behaviour, None, Status]:
        """Look at the entry, or go on with the child."""
        if self.child.status is not Status.RUNNING and not self.updated():
            return self.otherwise
        return (yield from self.tick_child())


class WaitValueUpdate(SkipUnlessUpdated):
    """Ticks its child if an entry has been written since it was ticked before, and ends as the child does.

    Otherwise it runs. While the child runs the entry is not looked at; a halt does not count as a look.
    """

    otherwise = Status.RUNNING


FAMILY = Family("entry_updates", {"SkipUnlessUpdated": SkipUnlessUpdated, "WaitValueUpdate": WaitValueUpdate})
