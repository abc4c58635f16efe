"""A tree for the hospital's fleet: samples, medicine and meals appear, and the nearest robot delivers them.

::

    hmrsim run hospital_fleet --clock lockstep
    bt-controller run bt_controller.examples.deliveries:deliver --robots all --set seed=3

If a robot breaks down on its way to an item, another robot gets the task. If it already has the item, it delivers it
once it works again. The tree succeeds if everything was delivered, and otherwise says what was not and why.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from py_trees.common import ParallelPolicy, Status
from py_trees.composites import Parallel, Sequence

from bt_controller.core.node import Leaf
from bt_controller.fleet.allocation import Task
from bt_controller.fleet.fleet_manager import FleetManager
from bt_controller.fleet.workers import Worker

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour

    from bt_controller.fleet.allocation import TaskQueue

_QUICK: Final = ("nurse", "courier", "responder")
_STRONG: Final = ("nurse", "porter")
"""The types of robots that can carry a tray; nurses can carry everything."""

TASKS: Final = (
    Task("medicine", "pharmacy", "ward_a", _QUICK),
    Task("medicine_2", "pharmacy", "ward_b", _QUICK),
    Task("bandages", "pharmacy", "ward_b", ("nurse",)),
    Task("blood_samples", "ward_a", "lab", _QUICK),
    Task("urine_samples", "ward_b_window", "lab", _QUICK),
    Task("meal", "kitchen", "ward_d", _STRONG),
    Task("meal_2", "kitchen", "ward_b_window", _STRONG),
    Task("soup", "kitchen", "ward_c", _STRONG),
)
"""The tasks, whose items and places are those of ``maps/hospital_fleet.yaml``."""


def deliver(robots: list[str]) -> Behaviour:
    """Return the tree of the whole fleet."""
    fleet_manager = FleetManager(robots, TASKS, seed=7, mean_gap=25.0)
    policy = ParallelPolicy.SuccessOnAll(synchronise=True)
    workers = Parallel(
        "Crew", policy=policy, children=[fleet_manager, *(Worker(robot, fleet_manager) for robot in robots)]
    )
    return Sequence("Deliveries", memory=True, children=[workers, AllDone(fleet_manager.task_queue)])


class AllDone(Leaf):
    """Succeeds if every task was done, and otherwise says which tasks were given up and why."""

    def __init__(self, task_queue: TaskQueue) -> None:
        super().__init__("All done")
        self._task_queue = task_queue

    def update(self) -> Status:
        """Return FAILURE if a task was given up, else SUCCESS."""
        done, lost = len(self._task_queue.done), self._task_queue.lost
        given_up = "".join(f"; {item} is given up: {why}" for item, why in lost.items())
        self.feedback_message = f"{done} of {done + len(lost)} tasks are done{given_up}"
        return Status.FAILURE if lost else Status.SUCCESS
