"""BehaviorTree.CPP's Sleep: let time go by."""

from __future__ import annotations

import math
from typing import ClassVar, Final

from py_trees.common import Status

from bt_controller.node import Leaf
from bt_controller.nodes import Family
from bt_controller.ports import INT, wants
from bt_controller.tree_time import now, reached

_MILLISECONDS: Final = 1000


class Sleep(Leaf):
    """Runs for a time, and succeeds then."""

    INPUTS: ClassVar = {"msec": wants(INT, "Simulated milliseconds")}

    def initialise(self) -> None:
        """Begin to sleep."""
        self._ends = now() + self.read("msec") / _MILLISECONDS

    def next_look(self) -> float:
        """Return when the time is over."""
        return self._ends if self.status is Status.RUNNING else math.inf

    def update(self) -> Status:
        """Look at the clock."""
        return Status.SUCCESS if reached(self._ends) else Status.RUNNING


FAMILY = Family("sleep", {"Sleep": Sleep})
