"""Nav2's DistanceController: a child that is ticked once per travelled distance."""

from __future__ import annotations

import math
from typing import ClassVar

from py_trees.common import Status

from bt_controller.core.node import EACH_PERIOD, Decoration, Ticks
from bt_controller.core.ports import FINITE, input_port
from bt_controller.nodes import Family
from bt_controller.nodes.located import BASE_FRAME, GLOBAL_FRAME, Located
from bt_controller.nodes.paths import apart


class DistanceController(Located, Decoration):
    """Ticks its child at once, and then whenever the robot is ``distance`` away from its position at the last success.

    The distance is in the world's unit of length, in a straight line. Otherwise the node is RUNNING. A RUNNING child is
    ticked until it has ended.
    """

    INPUTS: ClassVar = {
        "distance": input_port(FINITE, "The distance", default=1.0),
        "global_frame": GLOBAL_FRAME,
        "robot_base_frame": BASE_FRAME,
    }

    def initialise(self) -> None:
        """Start at the current position, if the node is idle."""
        if self.status is Status.INVALID:
            self._first = True
            self._start = self.here

    def next_tick_time(self) -> float:
        """Return that the robot's pose has to be polled, unless the child runs."""
        return math.inf if self.child.status is Status.RUNNING else EACH_PERIOD

    def advance(self) -> Ticks:
        """Tick the child if the robot has travelled far enough."""
        far = apart(self._start, self.here) >= self.read("distance")
        if not (self._first or self.child.status is Status.RUNNING or far):
            return Status.RUNNING
        self._first = False
        status = yield from self.tick_child()
        if status is Status.SUCCESS:
            self._start = self.here
        return status


FAMILY = Family("distance_controller", {"DistanceController": DistanceController})
