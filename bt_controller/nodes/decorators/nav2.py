"""Nav2's decorators: a child that is ticked by time, distance, speed or a changed goal, or once."""

from __future__ import annotations

import math
from typing import ClassVar

from py_trees.common import Status

from bt_controller.core.node import EACH_PERIOD, Decoration, PortError, Ticks
from bt_controller.core.ports import FINITE, PATH, POSE, POSES, POSITIVE, input_port, output_port
from bt_controller.core.sim_time import now, reached
from bt_controller.nodes import Family
from bt_controller.nodes.poses import BASE_FRAME, GLOBAL_FRAME, GOAL_PORTS, Located, apart, goals_of, length_of
from hmrsim.interfaces.nav_msgs import Path


class _Controller(Decoration):
    """A decorator that ticks its child when that is due, or RUNNING."""

    _next = EACH_PERIOD

    def next_tick_time(self) -> float:
        """Return when the child is due; a skipped one has to be polled, a RUNNING one has its own time."""
        if self.child.status is Status.RUNNING:
            return math.inf
        return EACH_PERIOD if self.status is Status.INVALID else self._next

    def _period_of(self, port: str) -> float:
        """Return the period, in seconds, of a rate in hertz.

        Raises:
            PortError: The rate is not positive.
        """
        rate: float = self.read(port)
        if rate <= 0.0:
            raise PortError(f"{self.name}: port {port!r}: {rate:g} is not a rate; expected a number greater than 0")
        return 1.0 / rate


class DistanceController(_Controller, Located):
    """Ticks its child at once, and then whenever the robot is ``distance`` away from its position at the last success.

    The distance is in the world's unit of length, in a straight line. Otherwise the node is RUNNING. A RUNNING child is
    ticked until it has ended.
    """

    INPUTS: ClassVar = {
        "distance": input_port(FINITE, "The distance", default=1.0),
        "global_frame": GLOBAL_FRAME,
        "robot_base_frame": BASE_FRAME,
    }

    def initialise(self) -> None:
        """Start at the current position, if the node is idle."""
        if self.status is Status.INVALID:
            self._first = True
            self._start = self.here

    def advance(self) -> Ticks:
        """Tick the child if the robot has traveled far enough."""
        far = apart(self._start, self.here) >= self.read("distance")
        if not (self._first or self.child.status is Status.RUNNING or far):
            return Status.RUNNING
        self._first = False
        status = yield from self.tick_child()
        if status is Status.SUCCESS:
            self._start = self.here
        return status


class GoalUpdatedController(_Controller):
    """Ticks its child at once, and then whenever ``goal`` or ``goals`` have changed; otherwise it is RUNNING.

    A RUNNING child is ticked until it has ended.
    """

    INPUTS: ClassVar = GOAL_PORTS

    def initialise(self) -> None:
        """Reset the trigger, if the node is idle."""
        if self.status is Status.INVALID:
            self._changed = True
            self._goals = goals_of(self)

    def advance(self) -> Ticks:
        """Tick the child if the goal has changed."""
        goals = goals_of(self)
        if not (self._changed or goals != self._goals or self.child.status is Status.RUNNING):
            return Status.RUNNING
        self._changed, self._goals = False, goals
        return (yield from self.tick_child())


class RateController(_Controller):
    """Ticks its child at once, and then at most ``hz`` times per simulated second; otherwise it is RUNNING.

    A RUNNING child is ticked until it has ended. The period counts from the last success, or from the first tick.
    """

    INPUTS: ClassVar = {"hz": input_port(POSITIVE, "Rate in hertz", default=10.0)}

    _first = True

    def initialise(self) -> None:
        """Reset the trigger, if the node is idle."""
        if self.status is Status.INVALID:
            self._first = True
            self._next = now() + self._period_of("hz")

    def advance(self) -> Ticks:
        """Tick the child if it is due."""
        if not (self._first or self.child.status is Status.RUNNING or reached(self._next)):
            return Status.RUNNING
        self._first = False
        status = yield from self.tick_child()
        if status is Status.SUCCESS:
            self._next = now() + self._period_of("hz")
        return status


class SpeedController(_Controller, Located):
    """Ticks its child at once, when the goal has changed, and otherwise at a rate that depends on the robot's speed.

    The rate is ``min_rate`` up to ``min_speed``, ``max_rate`` from ``max_speed`` on, and linear in between; it is
    computed at the end of each period, and the first period is that of ``max_rate``. Speeds are in the world's unit of
    length per second, rates in hertz of simulated time. Otherwise the node is RUNNING. A RUNNING child is ticked until
    it has ended.
    """

    INPUTS: ClassVar = {
        "min_rate": input_port(POSITIVE, "Lowest rate", default=0.1),
        "max_rate": input_port(POSITIVE, "Highest rate", default=1.0),
        "min_speed": input_port(FINITE, "Speed of the lowest rate", default=0.0),
        "max_speed": input_port(FINITE, "Speed of the highest rate", default=0.5),
        **GOAL_PORTS,
    }

    _first = True

    def initialise(self) -> None:
        """Start the first period, if the node is idle."""
        if self.status is Status.INVALID:
            self._begin()

    def advance(self) -> Ticks:
        """Tick the child if it is due."""
        if self._goals != goals_of(self):
            self._begin()
        over = reached(self._next)
        if not (self._first or self.child.status is Status.RUNNING or over):
            return Status.RUNNING
        self._first = False
        if over:
            self._next = now() + self._period()
        return (yield from self.tick_child())

    def _begin(self) -> None:
        self._goals = goals_of(self)
        self._first = True
        self._next = now() + self._period_of("max_rate")

    def _period(self) -> float:
        longest, shortest = self._period_of("min_rate"), self._period_of("max_rate")
        slow, fast = self.read("min_speed"), self.read("max_speed")
        velocity = self.odometry.twist.twist.linear
        speed = math.hypot(velocity.x, velocity.y)
        share = (speed - slow) / (fast - slow) if fast > slow else float(speed >= fast)
        return 1.0 / (1.0 / longest + min(max(share, 0.0), 1.0) * (1.0 / shortest - 1.0 / longest))


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


class PathLongerOnApproach(Decoration):
    """Ticks its child when a new path to the same goal is much longer than the previous, short one.

    The previous path has to be shorter than ``prox_len``, in the world's unit of length, and the new one more than
    ``length_factor`` times as long. Otherwise the node succeeds at once.
    """

    INPUTS: ClassVar = {
        "path": input_port(PATH, "The path", required=False),
        "prox_len": input_port(FINITE, "Largest length of the previous path", default=3.0),
        "length_factor": input_port(FINITE, "Smallest ratio of the lengths", default=2.0),
    }

    _old = Path()

    def advance(self) -> Ticks:
        """Compare the path with the previous one, and tick the child if it is much longer."""
        new = self.read("path") or Path()
        if self.child.status is not Status.RUNNING and not self._is_detour(new):
            self._old = new
            return Status.SUCCESS
        status = yield from self.tick_child()
        if status is not Status.RUNNING:
            self._old = new
        return status

    def _is_detour(self, new: Path) -> bool:
        old = self._old
        if not (old.poses and new.poses) or old.poses[-1].pose != new.poses[-1].pose:
            return False
        before = length_of(old)
        detour: bool = before < self.read("prox_len") and length_of(new) > self.read("length_factor") * before
        return detour


FAMILY = Family.of_module(__name__)
