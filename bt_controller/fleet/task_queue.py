"""The task queue of a fleet: waiting, assigned, finished and lost tasks, as plain data."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from bt_controller.fleet.allocation import PendingTask, nearest

if TYPE_CHECKING:
    from bt_controller.fleet.allocation import Assignment, Policy, Robot
    from bt_controller.fleet.tasks import Task


@dataclass
class Given:
    """A task that is assigned to a robot.

    Attributes:
        waiting: The task as it was in the queue.
        holds: Whether the robot holds its item.
    """

    waiting: PendingTask
    holds: bool = False

    @property
    def task(self) -> Task:
        """The task."""
        return self.waiting.task


@dataclass
class TaskQueue:
    """Assigns tasks, and queues failed ones again.

    Attributes:
        least: The charge below which robots get no tasks.
        waiting: The unassigned tasks, the longest waiting first.
        given: The assigned tasks, by robot.
        done: The tasks that are done.
        lost: The items of the tasks that were given up, with the reasons.
        loaded: The robots that hold an item of a task that was given up.
        closed: Whether no more tasks will appear, and none waits or is assigned.
    """

    policy: Policy = nearest
    least: float = 0.2
    waiting: list[PendingTask] = field(default_factory=list)
    given: dict[str, Given] = field(default_factory=dict)
    done: list[Task] = field(default_factory=list)
    lost: dict[str, str] = field(default_factory=dict)
    loaded: set[str] = field(default_factory=set)
    closed: bool = False

    def hand_out(self, robots: Sequence[Robot]) -> list[Assignment]:
        """Assign waiting tasks to robots; a robot with a task does not count as idle."""
        taken = {*self.given, *self.loaded}
        free = [replace(robot, idle=robot.idle and robot.name not in taken) for robot in robots]
        found = self.policy(self.waiting, free, least=self.least)
        by_item = {each.task.item: each for each in self.waiting}
        for each in found:
            self.given[each.robot] = Given(by_item.pop(each.task.item))
        self.waiting = list(by_item.values())
        return found

    def finish(self, robot: str) -> Task:
        """Note that a robot has done its task."""
        task = self.given.pop(robot).task
        self.done.append(task)
        return task

    def fail(self, robot: str) -> None:
        """Queue a robot's task again for other robots, in order of appearance.

        A robot that holds the item keeps the task, and brings the item when it can.
        """
        if not self.given[robot].holds:
            waiting = self.given.pop(robot).waiting
            self.waiting.append(replace(waiting, failed=waiting.failed | {robot}))
            self.waiting.sort(key=lambda each: (each.since, each.task.item))

    def give_up(self, robot: str, why: str) -> None:
        """Give up a robot's task, as the robot holds the item and can't bring it."""
        self.lost[self.given.pop(robot).task.item] = why
        self.loaded.add(robot)

    def give_up_waiting(self, robots: Iterable[Robot], *, before: float) -> list[str]:
        """Give up the tasks that none of these robots can do, and those that are too old; return their items."""
        known = list(robots)
        for each in self.waiting:
            if not any(robot.suits(each.task) for robot in known):
                self.lost[each.task.item] = "no robot can do it"
            elif each.since <= before:
                failed = f"; {', '.join(sorted(each.failed))} failed" if each.failed else ""
                self.lost[each.task.item] = f"it waited too long{failed}"
        gone = [each.task.item for each in self.waiting if each.task.item in self.lost]
        self.waiting = [each for each in self.waiting if each.task.item not in self.lost]
        return gone
