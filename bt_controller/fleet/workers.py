"""The workers of a fleet: behaviors that make each robot execute its assigned tasks, charge and drive home."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import TYPE_CHECKING, Any, Final

from py_trees.common import Status
from py_trees.composites import Sequence
from py_trees.timers import Timer

from bt_controller.core.action_leaf import ActionLeaf
from bt_controller.core.node import Control, Leaf, Ticks
from bt_controller.core.robots import NotServed
from bt_controller.core.sim_time import now
from hmrsim.interfaces.message import unbuilt
from hmrsim.interfaces.moveit_msgs import Pickup, Place
from hmrsim.interfaces.nav2_msgs import DockRobot, NavigateToPose, Wait

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour

    from bt_controller.fleet.allocation import Task, TaskQueue
    from bt_controller.fleet.fleet_manager import FleetManager

_LOOK_AGAIN: Final = 30.0
"""Simulated seconds after which a failed or charging robot is checked again."""


class Worker(Control):
    """The behavior of one robot of a fleet: it delivers items, charges, and drives home when it has no task.

    It runs until the task queue is closed. A robot that has failed gets no tasks until, after a pause, it executes a
    goal again.
    """

    def __init__(self, robot: str, fleet_manager: FleetManager) -> None:
        self._robot = robot
        self._fleet_manager = fleet_manager
        self._task_queue: TaskQueue = fleet_manager.task_queue
        self._fetch = self._steps("fetch", self._go("source"), self._lift())
        self._bring = self._steps("bring", self._go("target"), self._lay_down())
        self._home = self._leaf("go home", "dock_robot", self._dock)
        dock = self._leaf("go to the charger", "dock_robot", self._dock)
        self._charge = self._steps("charge", dock, Charged(f"{robot}: wait until charged", robot, fleet_manager))
        pause = Timer(f"{robot}: wait for repair", _LOOK_AGAIN)
        self._recover = self._steps("recover", pause, self._leaf("try whether it works", "wait", Wait.Goal))
        super().__init__(robot, [self._fetch, self._bring, self._recover, self._charge, self._home])

    def initialise(self) -> None:
        """Begin with a robot that is at home and works."""
        self._failed = self._away_from_home = False

    def advance(self) -> Ticks:
        """Tick the current step, and the next ones if it ends at once."""
        while (step := self._current_step()) is not None:
            for child in self.children:
                if child is not step:
                    self.halt(child)
            yield from step.tick()
            if step.status is Status.RUNNING:
                break
            succeeded, last = step.status is Status.SUCCESS, step.tip()
            why = last.feedback_message if last is not None else ""
            self.reset(step)
            self._ended(step, why, succeeded=succeeded)
            if step is self._bring:
                # The fleet manager may assign another task first.
                break
        self.feedback_message = self._state
        return Status.SUCCESS if self._task_queue.closed else Status.RUNNING

    @property
    def _state(self) -> str:
        given = self._task_queue.given.get(self._robot)
        task = "" if given is None else f"{'brings' if given.holds else 'fetches'} {given.task.item}"
        if self._failed:
            return f"{task or 'idle'}, out of order"
        return task or ("charges" if self._robot in self._fleet_manager.low else "idle")

    def _current_step(self) -> Behaviour | None:
        """Return the current step; None if there is nothing to do."""
        if self._task_queue.closed:
            return None
        if self._failed:
            return self._recover
        if given := self._task_queue.given.get(self._robot):
            self._away_from_home = True
            return self._bring if given.holds else self._fetch
        if self._robot in self._fleet_manager.low:
            return self._charge
        return self._home if self._away_from_home else None

    def _ended(self, step: Behaviour, why: str, *, succeeded: bool) -> None:
        """Process the end of a step."""
        if step is self._recover:
            self._failed = not succeeded
            self._fleet_manager.set_working(self._robot, working=succeeded)
        elif step is self._home:
            # A robot that can't get home stays where it is.
            self._away_from_home = False
        elif not succeeded:
            self._failed = True
            self._fleet_manager.failed(self._robot, why)
        elif step is self._charge:
            self._away_from_home = False
            self._fleet_manager.charged(self._robot)
        elif step is self._fetch:
            self._task_queue.given[self._robot].holds = True
        else:
            self._fleet_manager.finished(self._robot)

    def _steps(self, name: str, *steps: Behaviour) -> Behaviour:
        return Sequence(f"{self._robot}: {name}", memory=True, children=list(steps))

    def _go(self, end: str) -> Behaviour:
        def goal() -> NavigateToPose.Goal:
            return NavigateToPose.Goal(pose=self._fleet_manager.pose(getattr(self._task, end)))

        return self._leaf(f"go to the {end}", "navigate_to_pose", goal)

    def _lift(self) -> Behaviour:
        def goal() -> Mapping[str, Any]:
            return unbuilt(Pickup.Goal, target_name=self._task.item)

        return self._leaf("pick up", "pickup", goal, plain=True)

    def _lay_down(self) -> Behaviour:
        def goal() -> Mapping[str, Any]:
            return unbuilt(Place.Goal, attached_object_name=self._task.item)

        return self._leaf("lay down", "place", goal, plain=True)

    def _dock(self) -> DockRobot.Goal:
        """Return the goal of driving to the robot's initial pose."""
        return DockRobot.Goal(use_dock_id=False, dock_pose=self._fleet_manager.home(self._robot))

    def _leaf(self, name: str, action: str, goal: Callable[[], Any], *, plain: bool = False) -> Behaviour:
        return (_PlainStep if plain else _Step)(f"{self._robot}: {name}", action, goal, robot=self._robot)

    @property
    def _task(self) -> Task:
        return self._task_queue.given[self._robot].task


class Charged(Leaf):
    """Succeeds when a robot's battery has enough charge for further tasks."""

    def __init__(self, name: str, robot: str, fleet_manager: FleetManager) -> None:
        super().__init__(name)
        self._robot = robot
        self._fleet_manager = fleet_manager
        self._next = 0.0

    def update(self) -> Status:
        """Check the battery; RUNNING until it has enough charge."""
        charge = self._fleet_manager.charge(self._robot)
        self.feedback_message = f"{charge:.0%}"
        if charge >= self._fleet_manager.enough:
            return Status.SUCCESS
        self._next = now() + _LOOK_AGAIN
        return Status.RUNNING

    def next_tick_time(self) -> float:
        """Return the time of the next check."""
        return self._next


class _Step(ActionLeaf[Any, Any, Any]):
    """A leaf of a robot that may lack the action; such a robot never gets a task that needs it."""

    def setup(self, **kwargs: Any) -> None:
        """Look up the action, if the robot has it."""
        with suppress(NotServed):
            super().setup(**kwargs)


class _PlainStep(_Step):
    """A step that sends a goal of MoveIt as plain values, since these messages are large."""

    PLAIN = True
