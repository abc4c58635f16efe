"""Nav2's RateController: a child that is ticked at a limited rate."""

from __future__ import annotations

import math
from typing import ClassVar

from py_trees.common import Status

from bt_controller.core.node import EACH_PERIOD, Decoration, Ticks
from bt_controller.core.ports import POSITIVE, input_port
from bt_controller.core.sim_time import now, reached
from bt_controller.nodes import Family
from bt_controller.nodes.rates import period_of


class RateController(Decoration):
    """Ticks its child at once, and then at most ``hz`` times per simulated second; otherwise it is RUNNING.

    A RUNNING child is ticked until it has ended. The period counts from the last success, or from the first tick.
    """

    INPUTS: ClassVar = {"hz": input_port(POSITIVE, "Rate in hertz", default=10.0)}

    _first = True
    _next = 0.0

    def initialise(self) -> None:
        """Reset the trigger, if the node is idle."""
        if self.status is Status.INVALID:
            self._first = True
            self._next = now() + period_of(self, "hz")

    def next_tick_time(self) -> float:
        """Return when the child is due; a skipped one has to be polled, a RUNNING one has its own time."""
        if self.child.status is Status.RUNNING:
            return math.inf
        return EACH_PERIOD if self.status is Status.INVALID else self._next

    def advance(self) -> Ticks:
        """Tick the child if it is due."""
        if not (self._first or self.child.status is Status.RUNNING or reached(self._next)):
            return Status.RUNNING
        self._first = False
        status = yield from self.tick_child()
        if status is Status.SUCCESS:
            self._next = now() + period_of(self, "hz")
        return status


FAMILY = Family("rate_controller", {"RateController": RateController})
