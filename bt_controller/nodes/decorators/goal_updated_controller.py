"""Nav2's GoalUpdatedController: a child that is ticked when the goal has changed."""

from __future__ import annotations

import math
from typing import ClassVar

from py_trees.common import Status

from bt_controller.core.node import EACH_PERIOD, Decoration, Ticks
from bt_controller.nodes import Family
from bt_controller.nodes.goals import GOAL_PORTS, goals_of


class GoalUpdatedController(Decoration):
    """Ticks its child at once, and then whenever ``goal`` or ``goals`` have changed; otherwise it is RUNNING.

    A RUNNING child is ticked until it has ended.
    """

    INPUTS: ClassVar = GOAL_PORTS

    def initialise(self) -> None:
        """Reset the trigger, if the node is idle."""
        if self.status is Status.INVALID:
            self._changed = True
            self._goals = goals_of(self)

    def next_tick_time(self) -> float:
        """Return that the goal has to be polled, unless the child runs."""
        return math.inf if self.child.status is Status.RUNNING else EACH_PERIOD

    def advance(self) -> Ticks:
        """Tick the child if the goal has changed."""
        goals = goals_of(self)
        if not (self._changed or goals != self._goals or self.child.status is Status.RUNNING):
            return Status.RUNNING
        self._changed, self._goals = False, goals
        return (yield from self.tick_child())


FAMILY = Family("goal_updated_controller", {"GoalUpdatedController": GoalUpdatedController})
