"""BehaviorTree.CPP's timing decorators: Delay, Timeout."""

from __future__ import annotations

import math
from typing import ClassVar, Final

from py_trees.common import Status

from bt_controller.core.node import Decoration, Ticks
from bt_controller.core.ports import UNSIGNED, input_port
from bt_controller.core.sim_time import now, reached
from bt_controller.nodes import Family

_MILLISECONDS: Final = 1000


class Delay(Decoration):
    """Ticks its child after a delay, and returns the child's status."""

    INPUTS: ClassVar = {"delay_msec": input_port(UNSIGNED, "Simulated milliseconds")}

    def initialise(self) -> None:
        """Start the delay."""
        self._begins = now() + self.read("delay_msec") / _MILLISECONDS
        self._waits = True

    def next_tick_time(self) -> float:
        """Return when the child is due."""
        return self._begins if self.status is Status.RUNNING and self._waits else super().next_tick_time()

    def advance(self) -> Ticks:
        """Tick the child after the delay."""
        if self._waits and not reached(self._begins):
            return Status.RUNNING
        self._waits = False
        return (yield from self.tick_child())


class Timeout(Decoration):
    """Returns its child's status. A child that is RUNNING after the time limit is halted, and the node fails.

    A child that ends exactly at the limit counts as in time.
    """

    INPUTS: ClassVar = {"msec": input_port(UNSIGNED, "Simulated milliseconds; 0 for no limit")}

    def initialise(self) -> None:
        """Start the time limit."""
        self.feedback_message = ""
        limit = self.read("msec")
        self._ends = now() + limit / _MILLISECONDS if limit > 0 else math.inf

    def next_tick_time(self) -> float:
        """Return the end of the time limit."""
        return self._ends if self.status is Status.RUNNING else super().next_tick_time()

    def advance(self) -> Ticks:
        """Tick the child, and check the time limit."""
        status = yield from self.tick_child()
        if status is Status.RUNNING and self._ends < math.inf and reached(self._ends):
            self.feedback_message = "timed out"
            return Status.FAILURE
        return status


FAMILY = Family.of("timing", Delay, Timeout)
