"""The tasks of a fleet, and when they appear."""

from __future__ import annotations

import random
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence


@dataclass(frozen=True)
class Task:
    """An item that is to be brought from one place to another.

    Attributes:
        item: The item; no two tasks have the same.
        source: The place where it is.
        target: The place where it is to be.
        types: The types of robots that may do it; none for all.
        actions: What a robot has to be able to do for it.
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
    """A task that turns up.

    Attributes:
        after: Simulated seconds since the beginning.
        task: The task.
    """

    after: float
    task: Task


def arrivals(tasks: Sequence[Task], *, seed: int, mean_gap: float) -> list[Arrival]:
    """Return some tasks in random order, at random times; of the same seed the same.

    Args:
        tasks: Which.
        seed: Of order and times.
        mean_gap: Simulated seconds from one to the next on average; they are exponentially distributed.
    """
    chance = random.Random(seed)
    found, after = [], 0.0
    for task in chance.sample(tasks, len(tasks)):
        after += chance.expovariate(1.0 / mean_gap)
        found.append(Arrival(round(after, 3), task))
    return found
