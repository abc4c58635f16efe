"""Nav2's SpeedController: a child whose tick rate increases with the robot's speed."""

from __future__ import annotations

import math
from typing import ClassVar

from py_trees.common import Status

from bt_controller.core.node import EACH_PERIOD, Decoration, Ticks
from bt_controller.core.ports import FINITE, POSITIVE, input_port
from bt_controller.core.sim_time import now, reached
from bt_controller.nodes import Family
from bt_controller.nodes.goals import GOAL_PORTS, goals_of
from bt_controller.nodes.located import Located
from bt_controller.nodes.rates import period_of


class SpeedController(Located, Decoration):
    """Ticks its child at once, when the goal has changed, and otherwise at a rate that depends on the robot's speed.

    The rate is ``min_rate`` up to ``min_speed``, ``max_rate`` from ``max_speed`` on, and linear in between; it is
    computed at the end of each period, and the first period is that of ``max_rate``. Speeds are in the world's unit of
    length per second, rates in hertz of simulated time. Otherwise the node is RUNNING. A RUNNING child is ticked until
    it has ended.
    """

    INPUTS: ClassVar = {
        "min_rate": input_port(POSITIVE, "Lowest rate", default=0.1),
        "max_rate": input_port(POSITIVE, "Highest rate", default=1.0),
        "min_speed": input_port(FINITE, "Speed of the lowest rate", default=0.0),
        "max_speed": input_port(FINITE, "Speed of the highest rate", default=0.5),
        **GOAL_PORTS,
    }

    _first = True
    _next = 0.0

    def initialise(self) -> None:
        """Start the first period, if the node is idle."""
        if self.status is Status.INVALID:
            self._begin()

    def next_tick_time(self) -> float:
        """Return the end of the period; a skipped child has to be polled, a RUNNING one has its own time."""
        if self.child.status is Status.RUNNING:
            return math.inf
        return EACH_PERIOD if self.status is Status.INVALID else self._next

    def advance(self) -> Ticks:
        """Tick the child if it is due."""
        if self._goals != goals_of(self):
            self._begin()
        over = reached(self._next)
        if not (self._first or self.child.status is Status.RUNNING or over):
            return Status.RUNNING
        self._first = False
        if over:
            self._next = now() + self._period()
        return (yield from self.tick_child())

    def _begin(self) -> None:
        self._goals = goals_of(self)
        self._first = True
        self._next = now() + period_of(self, "max_rate")

    def _period(self) -> float:
        longest, shortest = period_of(self, "min_rate"), period_of(self, "max_rate")
        slow, fast = self.read("min_speed"), self.read("max_speed")
        velocity = self.odometry.twist.twist.linear
        speed = math.hypot(velocity.x, velocity.y)
        share = (speed - slow) / (fast - slow) if fast > slow else float(speed >= fast)
        return 1.0 / (1.0 / longest + min(max(share, 0.0), 1.0) * (1.0 / shortest - 1.0 / longest))


FAMILY = Family("speed_controller", {"SpeedController": SpeedController})
