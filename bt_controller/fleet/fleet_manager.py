"""The manager of a fleet: it knows the robots, generates tasks, and assigns them through the task queue."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from py_trees.blackboard import Blackboard
from py_trees.common import Status

from bt_controller.core.node import Leaf
from bt_controller.core.sim_time import now, reached
from bt_controller.errors import TreeError
from bt_controller.fleet.allocation import PendingTask, Robot, TaskQueue, arrivals
from hmrsim.interfaces.geometry_msgs import PoseStamped

if TYPE_CHECKING:
    from bt_controller.core.robots import Directory, Topics
    from bt_controller.fleet.allocation import Arrival, Assignment, Given, Task
    from hmrsim.interfaces.nav_msgs import Odometry
    from hmrsim_zenoh.client.places import NamedPlaces

_SEED = "seed"
"""The key of the blackboard that has the seed of the tasks."""
_ODOMETRY, _BATTERY = "odom", "battery_state"


class FleetManager(Leaf):
    """Generates tasks and assigns each to a robot; succeeds when all of them are done or given up.

    It is ticked when a task appears and when a robot becomes idle; no polling is needed.

    Args:
        seed: The seed of the tasks' arrival times, if the blackboard has no ``seed``.
        mean_gap: Simulated seconds between two tasks, on average.
        enough: The charge up to which robots charge.
        patience: Simulated seconds after which a waiting task, or one of a failed robot, is given up.
    """

    def __init__(
        self,
        robots: Sequence[str],
        tasks: Sequence[Task],
        *,
        seed: int,
        mean_gap: float,
        task_queue: TaskQueue | None = None,
        enough: float = 0.8,
        patience: float = 900.0,
    ) -> None:
        super().__init__("Office")
        self.task_queue = task_queue or TaskQueue()
        self.enough = enough
        self.low: set[str] = set()
        self._robots = tuple(robots)
        self._tasks = tuple(tasks)
        self._seed = seed
        self._mean_gap = mean_gap
        self._patience = patience
        self._broken: set[str] = set()
        self._to_come: list[Arrival] = []
        self._news: list[str] = []

    def setup(self, **kwargs: Any) -> None:
        """Look up the robots that can do any of the tasks.

        Raises:
            TreeError: The seed is not a whole number.
            NotServed: A robot does not tell where it is.
        """
        super().setup(**kwargs)
        self._seed = _seed(self._seed)
        self._directory: Directory = kwargs["directory"]
        self._topics: Topics = kwargs["topics"]
        self._names: NamedPlaces = kwargs["places"]
        self._wake: Callable[[], None] = kwargs["wake"]
        types, actions = self._directory.types, self._directory.actions
        self._able = [
            robot for robot in self._robots if any(task.suits(types[robot], actions[robot]) for task in self._tasks)
        ]
        for robot in self._able:
            self._topics.watch(robot, _ODOMETRY)
            if self._has_battery(robot):
                self._topics.watch(robot, _BATTERY)
        self._homes = {robot: self._where(robot) for robot in self._able}

    def initialise(self) -> None:
        """Draw the arrival times of the tasks."""
        self._began = now()
        self._to_come = arrivals(self._tasks, seed=self._seed, mean_gap=self._mean_gap)

    def update(self) -> Status:
        """Accept new tasks, and assign waiting ones."""
        while self._to_come and reached(self._began + self._to_come[0].after):
            task = self._to_come.pop(0).task
            at = self.pose(task.source).pose.position
            self.task_queue.waiting.append(PendingTask(task, (at.x, at.y), since=now()))
            self._news.append(f"new task: {task.item} from {task.source} to {task.target}")
        self._give_up_held()
        if self.task_queue.waiting:
            self._hand_out()
        self.task_queue.closed = not (self._to_come or self.task_queue.waiting or self.task_queue.given)
        if self._news:
            self.feedback_message, self._news = "; ".join(self._news), []
        return Status.SUCCESS if self.task_queue.closed else Status.RUNNING

    def next_tick_time(self) -> float:
        """Return when the next task appears or times out."""
        arrival = self._began + self._to_come[0].after if self._to_come else math.inf
        waiting = [*self.task_queue.waiting, *(given.waiting for given in self._held())]
        return min([arrival, *(each.since + self._patience for each in waiting)])

    def finished(self, robot: str) -> None:
        """Record that a robot has done its task."""
        task = self.task_queue.finish(robot)
        self._check_charge(robot, self.charge(robot))
        self._tell(f"{robot} has brought {task.item} to {task.target}")

    def failed(self, robot: str, why: str) -> None:
        """Record that a robot has failed at its task or at charging."""
        self._broken.add(robot)
        given = self.task_queue.given.get(robot)
        what = "charge" if given is None else f"{'bring' if given.holds else 'fetch'} {given.task.item}"
        if given is not None:
            self.task_queue.fail(robot)
        self._tell(f"{robot} can't {what}: {why}")

    def gave_up(self, robot: str) -> None:
        """Record that a robot's task is given up, as no other robot can do it."""
        item = self.task_queue.given[robot].task.item
        self.task_queue.give_up(robot, f"{robot} holds it and is out of order")
        self._tell(f"{item} is given up: {self.task_queue.lost[item]}")

    def charged(self, robot: str) -> None:
        """Record that a robot's battery is charged."""
        self.low.discard(robot)
        self._tell(f"{robot} is charged")

    def set_working(self, robot: str, *, working: bool) -> None:
        """Record whether a robot works."""
        if working:
            self._broken.discard(robot)
            self._wake()
        else:
            self._broken.add(robot)

    def pose(self, place: str) -> PoseStamped:
        """Return the pose of a place."""
        return self._names.pose(place)

    def home(self, robot: str) -> PoseStamped:
        """Return a robot's initial pose."""
        return self._homes[robot]

    def charge(self, robot: str) -> float:
        """Return the charge of a robot's battery, 0 to 1; 1 if it has none."""
        return float(self._topics.latest(robot, _BATTERY).percentage) if self._has_battery(robot) else 1.0

    def _hand_out(self) -> None:
        robots = [self._robot(name) for name in self._able]
        for item in self.task_queue.give_up_waiting(robots, before=now() - self._patience):
            self._news.append(f"{item} is given up: {self.task_queue.lost[item]}")
        for robot in robots:
            if robot.idle:
                self._check_charge(robot.name, robot.charge)
        self._news += [_assigned(each) for each in self.task_queue.hand_out(robots)]

    def _check_charge(self, robot: str, charge: float) -> None:
        if charge < self.task_queue.least:
            self.low.add(robot)
            self._news.append(f"{robot} has to charge: {charge:.0%}")

    def _held(self) -> list[Given]:
        """Return the tasks of robots that have failed."""
        return [given for robot, given in self.task_queue.given.items() if robot in self._broken]

    def _give_up_held(self) -> None:
        for robot, given in list(self.task_queue.given.items()):
            if robot in self._broken and reached(given.waiting.since + self._patience):
                self.gave_up(robot)

    def _robot(self, name: str) -> Robot:
        at = self._where(name).pose.position
        return Robot(
            name,
            self._directory.types[name],
            self._directory.actions[name],
            (at.x, at.y),
            charge=self.charge(name),
            idle=name not in self._broken and name not in self.low and name not in self.task_queue.given,
        )

    def _where(self, robot: str) -> PoseStamped:
        odometry: Odometry = self._topics.latest(robot, _ODOMETRY)
        return PoseStamped(header=odometry.header, pose=odometry.pose.pose)

    def _has_battery(self, robot: str) -> bool:
        return "battery" in self._directory.components[robot]

    def _tell(self, news: str) -> None:
        self._news.append(news)
        self._wake()


def _assigned(assignment: Assignment) -> str:
    return f"{assignment.robot} gets {assignment.task.item}, {assignment.distance:.1f} away"


def _seed(default: int) -> int:
    """Return the seed from the blackboard, as set by ``--set seed=3``, or the default."""
    if not Blackboard.exists(_SEED):
        return default
    try:
        return int(Blackboard.get(_SEED))
    except (TypeError, ValueError):
        raise TreeError(f"{_SEED} {Blackboard.get(_SEED)!r} is not a whole number") from None
