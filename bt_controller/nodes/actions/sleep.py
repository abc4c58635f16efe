"""BehaviorTree.CPP's Sleep: wait for simulated time."""

from __future__ import annotations

from typing import ClassVar, Final

from py_trees.common import Status

from bt_controller.core.node import EACH_PERIOD, Leaf
from bt_controller.core.ports import UNSIGNED, input_port
from bt_controller.core.sim_time import now, reached
from bt_controller.nodes import Family

_MILLISECONDS: Final = 1000


class Sleep(Leaf):
    """Runs for a duration, and then succeeds."""

    INPUTS: ClassVar = {"msec": input_port(UNSIGNED, "Simulated milliseconds")}

    def initialise(self) -> None:
        """Begin to sleep."""
        self._ends = now() + self.read("msec") / _MILLISECONDS

    def next_tick_time(self) -> float:
        """Return the end of the duration; a node that has ended sleeps again when it is ticked again."""
        return self._ends if self.status is Status.RUNNING else EACH_PERIOD

    def update(self) -> Status:
        """Check the time."""
        return Status.SUCCESS if reached(self._ends) else Status.RUNNING


FAMILY = Family.of("sleep", Sleep)
