"""BehaviorTree.CPP's Precondition: a script that decides whether a child starts."""

from __future__ import annotations

from typing import ClassVar

from py_trees.common import Status

from bt_controller.core.node import EACH_PERIOD, Decoration, Ticks
from bt_controller.core.ports import STATUS, input_port
from bt_controller.nodes import Family
from bt_controller.scripting.ports import Scripted


class Precondition(Scripted, Decoration):
    """Ticks its child if a script is true, and returns the child's status; otherwise returns *else*.

    The script is not evaluated while the child is RUNNING.
    """

    SCRIPTS: ClassVar = ("if",)
    INPUTS: ClassVar = {"else": input_port(STATUS, "Status if the script is false", default=Status.FAILURE)}

    def next_tick_time(self) -> float:
        """Return that the script has to be polled, unless the child is RUNNING."""
        return super().next_tick_time() if self.child.status is Status.RUNNING else EACH_PERIOD

    def advance(self) -> Ticks:
        """Run the script, or tick the RUNNING child."""
        if self.child.status is not Status.RUNNING and not self.holds("if"):
            otherwise: Status = self.read("else")
            return otherwise
        return (yield from self.tick_child())


FAMILY = Family.of("precondition", Precondition)
