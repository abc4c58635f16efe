"""The tasks of a fleet, their queue, and the policies that assign them to robots.

A policy is a function of the current tasks and robots; `nearest` is one.
"""

from __future__ import annotations

import math
import random
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Protocol


@dataclass(frozen=True)
class PendingTask:
    """A task that waits for a robot.

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
    """A function that assigns the waiting tasks of a fleet to its robots."""

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
        """The task that the robot has."""
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
        closed: Whether all tasks have appeared, and none waits or is assigned.
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
        """Record that a robot has done its task."""
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


@dataclass(frozen=True)
class Task:
    """The delivery of an item from one place to another.

    Attributes:
        item: The item, which is unique among the tasks.
        types: The types of robots that may do it; empty for all.
        actions: The actions that a robot needs for it.
    """

    item: str
    source: str
    target: str
    types: tuple[str, ...] = ()
    actions: tuple[str, ...] = ("navigate_to_pose", "pickup", "place")

    def suits(self, robot_type: str, actions: Sequence[str]) -> bool:
        """Return whether a robot of a type, with some actions, can do it."""
        return (not self.types or robot_type in self.types) and set(self.actions) <= set(actions)


@dataclass(frozen=True)
class Arrival:
    """The arrival of a task.

    Attributes:
        after: Simulated seconds since the start.
    """

    after: float
    task: Task


def arrivals(tasks: Sequence[Task], *, seed: int, mean_gap: float) -> list[Arrival]:
    """Return tasks in random order, at random times; equal seeds give equal arrivals.

    Args:
        tasks: The tasks.
        seed: The seed of order and times.
        mean_gap: Simulated seconds between two tasks on average; the gaps are exponentially distributed.
    """
    chance = random.Random(seed)
    found, after = [], 0.0
    for task in chance.sample(tasks, len(tasks)):
        after += chance.expovariate(1.0 / mean_gap)
        found.append(Arrival(round(after, 3), task))
    return found
