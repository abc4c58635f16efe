"""Nav2's GoalUpdater, without Nav2's topic of goal updates, which this simulator does not have."""

from __future__ import annotations

from typing import ClassVar

from bt_controller.core.node import Decoration, Ticks
from bt_controller.core.ports import POSE, POSES, input_port, output_port
from bt_controller.nodes import Family


class GoalUpdater(Decoration):
    """Copies its input goals to its output ports at each tick, and returns its child's status.

    A node that has another goal for the robot writes it to the entry of ``input_goal``.
    """

    INPUTS: ClassVar = {
        "input_goal": input_port(POSE, "The goal", required=False),
        "input_goals": input_port(POSES, "The goals", required=False),
    }
    OUTPUTS: ClassVar = {"output_goal": output_port(POSE, "The goal"), "output_goals": output_port(POSES, "The goals")}

    def advance(self) -> Ticks:
        """Copy the goals, and tick the child."""
        for what in ("goal", "goals"):
            value = self.read(f"input_{what}")
            if value is not None:
                self.write(f"output_{what}", value)
        return (yield from self.tick_child())


FAMILY = Family.of("goal_updater", GoalUpdater)
