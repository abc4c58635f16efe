"""Task allocation. A policy is a function of the current tasks and robots; `nearest` is one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from bt_controller.fleet.tasks import Task


@dataclass(frozen=True)
class PendingTask:
    """An unassigned task.

    Attributes:
        at: The item's position, in the world's unit of length.
        since: When the task appeared, in simulated seconds.
        failed: The robots that have failed at it: others have precedence.
    """

    task: Task
    at: tuple[float, float]
    since: float = 0.0
    failed: frozenset[str] = frozenset()


@dataclass(frozen=True)
class Robot:
    """A robot's state for allocation.

    Attributes:
        actions: The names of its actions.
        at: Its position, in the world's unit of length.
        charge: The charge of its battery, 0 to 1; 1 without a battery.
        idle: Whether it works and has no task.
    """

    name: str
    type: str
    actions: tuple[str, ...]
    at: tuple[float, float]
    charge: float = 1.0
    idle: bool = True

    def suits(self, task: Task) -> bool:
        """Return whether the robot can do a task, now or later."""
        return task.suits(self.type, self.actions)


@dataclass(frozen=True)
class Assignment:
    """A task and the robot that gets it.

    Attributes:
        distance: The robot's distance in a straight line.
    """

    task: Task
    robot: str
    distance: float


class Policy(Protocol):
    """An allocation policy."""

    def __call__(self, waiting: Sequence[PendingTask], robots: Sequence[Robot], *, least: float) -> list[Assignment]:
        """Assign robots to tasks; no task and no robot twice.

        Args:
            waiting: The tasks, the longest waiting first.
            robots: All robots, also those that are busy.
            least: The charge below which a robot gets nothing.
        """


def nearest(waiting: Sequence[PendingTask], robots: Sequence[Robot], *, least: float) -> list[Assignment]:
    """Assign each task, the longest waiting first, to the nearest idle robot.

    A robot that has failed at the task gets it again only if no other is idle; equal distances are ordered by name.
    """
    free = [robot for robot in robots if robot.idle and robot.charge >= least]
    found = []
    for each in waiting:
        suitable = [robot for robot in free if robot.suits(each.task)]
        if suitable:
            best = min(suitable, key=lambda it: (it.name in each.failed, math.dist(it.at, each.at), it.name))
            free.remove(best)
            found.append(Assignment(each.task, best.name, math.dist(best.at, each.at)))
    return found
