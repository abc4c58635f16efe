"""One plain dispatcher that serves the orders of a world, and what goes wrong meanwhile.

The nearest idle robot that lifts the item drives to it, picks it up, drives to its destination and places it. A drive
that ends with code 104 is tried once more. Robots that are done stay where they are, and none is ever charged.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import combinations
from typing import TYPE_CHECKING, NamedTuple

from hmrsim.errors import NoRoute
from hmrsim.events.orders import OrderDelivered, OrderPlaced
from hmrsim.events.traffic import Deadlock
from hmrsim.geometry import SAME_PLACE, distance
from hmrsim.interfaces.geometry_msgs import Point as PointMessage
from hmrsim.interfaces.geometry_msgs import Pose, PoseStamped
from hmrsim.interfaces.moveit_msgs import Pickup, Place
from hmrsim.interfaces.nav2_msgs import FollowPath, NavigateToPose
from hmrsim.protocol.commands import SendGoal
from hmrsim.protocol.goal import GoalStatus
from hmrsim.protocol.outputs import EventStamped, GoalChanged
from hmrsim.protocol.topics import Topic
from hmrsim.random_fleets.oracle import lifts
from hmrsim.simulation.simulator import Simulator
from hmrsim.traffic.nearness import rooms_of_waypoints

if TYPE_CHECKING:
    from hmrsim.geometry import Point
    from hmrsim.protocol.outputs import Output
    from hmrsim.robots.robot import Robot
    from hmrsim.world.model import World

LIMIT = 7_200.0
"""Simulated seconds after which a run is ended."""

_BLOCKED = FollowPath.Result.PATIENCE_EXCEEDED


@dataclass
class Outcome:
    """The outcome of one run.

    Attributes:
        served: Orders that were delivered.
        total: Orders that were placed.
        aborted: Each goal that was aborted: when, which robot, its action and destination, and why.
        touching: Pairs of robots that stand or wait so near that they touch, and since when; pairs that touch at the
            start, or share a waypoint with room for several, are none, and neither is one at a stop of a lift.
        waiting: The robots that still wait at the end, and what they wait for.
        deadlocks: Deadlocks that were published.
        longest: The longest processor time of an instant of simulated time, in seconds, and when that was.
        took: The processor time of the simulator, in seconds.
        makespan: When the last order was delivered, in simulated seconds.
        ended: When the run was over.
    """

    served: int = 0
    total: int = 0
    aborted: list[str] = field(default_factory=list)
    touching: list[str] = field(default_factory=list)
    waiting: list[str] = field(default_factory=list)
    deadlocks: int = 0
    longest: tuple[float, float] = (0.0, 0.0)
    took: float = 0.0
    makespan: float = 0.0
    ended: float = 0.0

    @property
    def flawless(self) -> bool:
        """True if every order was served, no robots touched, and no robot waits forever."""
        return self.served == self.total and not (self.touching or self.waiting)


def dispatched(world: World, limit: float = LIMIT) -> Outcome:
    """Run a world with the plain dispatcher until nothing is due, for at most *limit* simulated seconds."""
    outcome = Outcome()
    dispatcher = _Dispatcher(world, outcome)
    simulator = Simulator(world, sinks=[dispatcher])
    dispatcher.simulator = simulator
    touching = _Touching(simulator, outcome)
    due = 0.0
    while due <= limit:
        began = time.process_time()
        simulator.advance(due)
        simulator.finish_instant()
        while dispatcher.act():
            simulator.finish_instant()
        took = time.process_time() - began
        outcome.took += took
        outcome.longest = max(outcome.longest, (took, simulator.now))
        touching.look()
        due = simulator.next_due
    outcome.ended = simulator.now
    outcome.waiting = [_wait_of(robot) for robot in simulator.robots.values() if robot.waits]
    return outcome


def _wait_of(robot: Robot) -> str:
    x, y = robot.pose().point
    return f"{robot.name} at ({x:g}, {y:g})"


class _Task(NamedTuple):
    """The task that a robot works on.

    Attributes:
        order: The order.
        step: The index of the current one of its four goals.
        tries: The number of attempts at this goal.
    """

    order: OrderPlaced
    step: int = 0
    tries: int = 1


class _Dispatcher:
    """A sink that hears of orders and of goals that have ended, and acts on them between instants."""

    def __init__(self, world: World, outcome: Outcome) -> None:
        self.simulator: Simulator | None = None
        self._world = world
        self._outcome = outcome
        self._weights = {spec.name: spec.weight for spec in world.demand}
        self._waiting: list[OrderPlaced] = []
        self._tasks: dict[str, _Task] = {}
        self._stuck: dict[str, None] = {}
        self._ended: list[GoalChanged] = []

    def emit(self, output: Output) -> None:
        """Note an order, or a goal that has ended."""
        if isinstance(output, GoalChanged):
            if output.status.terminal:
                self._ended.append(output)
        elif isinstance(output, EventStamped):
            event = output.event
            if isinstance(event, OrderPlaced):
                self._waiting.append(event)
                self._outcome.total += 1
            elif isinstance(event, OrderDelivered):
                self._outcome.served += 1
                self._outcome.makespan = output.stamp / 1e9
            elif isinstance(event, Deadlock):
                self._outcome.deadlocks += 1

    def wants(self, topic: Topic) -> bool:
        """Return whether it takes a topic."""
        return topic is Topic.EVENTS

    def act(self) -> bool:
        """Send what is to be sent now; return whether anything was."""
        ended, self._ended = self._ended, []
        for change in ended:
            self._follow(change)
        sent = any(change.robot in self._tasks for change in ended)
        for order in [*self._waiting]:
            robot = self._nearest(order)
            if robot is not None:
                self._waiting.remove(order)
                self._tasks[robot] = _Task(order)
                self._send(robot)
                sent = True
        return sent

    def _follow(self, change: GoalChanged) -> None:
        """Go on after a goal has ended."""
        robot, task = change.robot, self._tasks.pop(change.robot)
        if change.status is GoalStatus.SUCCEEDED:
            if task.step < len(_STEPS) - 1:
                self._tasks[robot] = _Task(task.order, task.step + 1)
                self._send(robot)
            return
        code, text = _why(change)
        self._outcome.aborted.append(f"{self._now:.1f} s {robot} {_STEPS[task.step].format(task.order)}: {text}")
        if code == _BLOCKED and task.tries == 1:
            self._tasks[robot] = task._replace(tries=2)
            self._send(robot)
        elif task.step > 1:
            # It holds the item, so that it can pick up no other one.
            self._stuck[robot] = None

    @property
    def _now(self) -> float:
        return self._running.now

    @property
    def _running(self) -> Simulator:
        if self.simulator is None:
            raise AssertionError
        return self.simulator

    def _nearest(self, order: OrderPlaced) -> str | None:
        """Return the idle robot that is the soonest at an item; None if there is none that can be."""
        weight, point = self._weights[order.order.rpartition("_")[0]], self._world.point(order.from_)
        found: list[tuple[float, str]] = []
        for name, robot in self._running.robots.items():
            if name not in self._tasks and name not in self._stuck and lifts(self._world, name, weight):
                seconds = self._seconds(robot, point)
                if seconds < math.inf:
                    found.append((seconds, name))
        return min(found)[1] if found else None

    def _seconds(self, robot: Robot, point: Point) -> float:
        try:
            return sum(leg.seconds(robot.speed) for leg in robot.plan_to(point).legs)
        except NoRoute:
            return math.inf

    def _send(self, robot: str) -> None:
        task = self._tasks[robot]
        action, goal = _goal(task, self._world)
        self._running.submit(SendGoal(robot, action, goal))


_STEPS = ("to {0.from_}", "picks up {0.item}", "to {0.to}", "places {0.item}")


def _goal(task: _Task, world: World) -> tuple[str, NavigateToPose.Goal | Pickup.Goal | Place.Goal]:
    """Return the action and the goal of the step of a task."""
    order = task.order
    if task.step == 1:
        return "pickup", Pickup.Goal(target_name=order.item)
    if task.step == len(_STEPS) - 1:
        return "place", Place.Goal(attached_object_name=order.item)
    x, y = world.point(order.to if task.step else order.from_)
    return "navigate_to_pose", NavigateToPose.Goal(pose=PoseStamped(pose=Pose(position=PointMessage(x=x, y=y))))


def _why(change: GoalChanged) -> tuple[int, str]:
    """Return the code of a goal that has failed, and its text."""
    result = change.result
    if isinstance(result, NavigateToPose.Result):
        return result.error_code, f"{result.error_code} {result.error_msg}"
    if isinstance(result, (Pickup.Result, Place.Result)):
        return result.error_code.val, f"{result.error_code.val} {result.error_code.message}"
    return 0, change.status.name


class _Touching:
    """Looks for robots at rest that touch."""

    def __init__(self, simulator: Simulator, outcome: Outcome) -> None:
        self._simulator = simulator
        self._outcome = outcome
        self._seen: dict[tuple[str, str], None] = dict.fromkeys(self._pairs(also_moving=True))
        points, rooms = simulator.world.points, rooms_of_waypoints(simulator.world, 1)
        self._roomy = [points[name] for name, room in rooms.items() if room > 1]
        self._endless = [points[name] for name, room in rooms.items() if room == math.inf]

    def look(self) -> None:
        """Note the pairs that touch now, each once."""
        for one, other in self._pairs():
            if (one, other) not in self._seen:
                self._seen[one, other] = None
                robots = self._simulator.robots
                a, b = robots[one].pose().point, robots[other].pose().point
                if self._may_touch(a, b):
                    del self._seen[one, other]
                    continue
                text = f"{self._simulator.now:.1f} s {one} at ({a[0]:g}, {a[1]:g}), {other} at ({b[0]:g}, {b[1]:g})"
                self._outcome.touching.append(text)

    def _may_touch(self, a: Point, b: Point) -> bool:
        """Return whether two robots share a waypoint, or one is where there is room for any number, as at a lift."""
        ends = [(distance(a, point) <= SAME_PLACE, distance(b, point) <= SAME_PLACE) for point in self._roomy]
        endless = (distance(at, point) <= SAME_PLACE for at in (a, b) for point in self._endless)
        return (True, True) in ends or any(endless)

    def _pairs(self, *, also_moving: bool = False) -> Iterator[tuple[str, str]]:
        still = [robot for robot in self._simulator.robots.values() if also_moving or robot.stands or robot.waits]
        points = [robot.pose().point for robot in still]
        for (i, one), (j, other) in combinations(enumerate(still), 2):
            if one.flies or other.flies:
                continue
            if distance(points[i], points[j]) < one.radius + other.radius - SAME_PLACE:
                yield one.name, other.name
