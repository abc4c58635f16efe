"""The tasks of a fleet, and when they appear."""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import dataclass


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
