"""A run of a world with orders: idle robots, free orders, and the goals with which robots serve them.

The run needs no client: it submits goals to the simulator, which hands their results back.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Any, Final, Literal, TypeAlias

from hmrsim.engine.sim_time import end_of_instant
from hmrsim.geometry import distance
from hmrsim.interfaces.geometry_msgs import Point as PointMessage
from hmrsim.interfaces.geometry_msgs import Pose, PoseStamped
from hmrsim.interfaces.moveit_msgs import Pickup, Place
from hmrsim.interfaces.nav2_msgs import DockRobot, NavigateToPose
from hmrsim.program.memory import collect_runs_young
from hmrsim.protocol.commands import SendGoal
from hmrsim.protocol.goal import GoalResponse, GoalStatus, ResultResponse
from hmrsim.protocol.outputs import OrdersChanged, Receiver, RosterChanged
from hmrsim.protocol.sinks import SelectiveSink
from hmrsim.protocol.topics import Comparison, Topic, Watch
from hmrsim.settings.run import RunSettings
from hmrsim.simulation.demand import OrderState
from hmrsim.simulation.simulator import Simulator
from hmrsim.timing.conditions import Conditions
from hmrsim_gym.setting import CHARGED

if TYPE_CHECKING:
    from hmrsim.geometry import Point
    from hmrsim.interfaces.message import Message
    from hmrsim.protocol.sinks import Sink
    from hmrsim.simulation.demand import Demand, Order
    from hmrsim_gym.setting import Setting


class Truth:
    """Reads the state of a simulator without changing it."""

    def __init__(self, simulator: Simulator, setting: Setting) -> None:
        self._roster, self._env = simulator.roster, simulator.env
        self._setting = setting
        self.demand: Demand = simulator.demand

    def point(self, robot: str) -> Point:
        """Return the position of a robot."""
        return self._roster.robots[robot].pose().point

    def item_point(self, order: Order) -> Point:
        """Return the position of an order's item."""
        return self._roster.items[order.item].position

    def destination(self, order: Order) -> Point:
        """Return the point to which an order's item is delivered."""
        return self._setting.world.point(order.to)

    def carries(self, robot: str, order: Order) -> bool:
        """Return whether a robot carries an order's item."""
        item = self._roster.items.get(order.item)
        return item is not None and item.carrier is not None and item.carrier.name == robot

    def seconds(self, robot: str, start: Point, goal: Point) -> float:
        """Return the seconds that a robot takes at its maximum speed, along the route, or straight if it flies."""
        its = self._roster.robots[robot]
        if its.flies:
            return distance(start, goal) / its.speed
        return self._setting.routes.seconds(start, goal, its.speed)

    def battery(self, robot: str) -> float:
        """Return the charge of a robot's battery as a share; 1 if it has none."""
        energy = self._roster.robots[robot].energy
        return 1.0 if energy is None else energy.battery.share(self._env.now)

    def lasts(self, robot: str) -> float:
        """Return the seconds until a robot has to charge at its present power.

        Negative if it has to now, infinite if it never has to.
        """
        energy = self._roster.robots[robot].energy
        if energy is None or not self._setting.chargers[robot]:
            return math.inf
        battery = energy.battery
        left = battery.share(self._env.now) - self._setting.charge_below
        if left < 0.0:
            return left
        # A whole second later, so that rounding can't leave it just above the limit.
        discharges = battery.drain and not battery.charging
        return math.floor(left * battery.usable / battery.drain) + 1.0 if discharges else math.inf

    def charger(self, robot: str, bound: Mapping[str, str]) -> str:
        """Return the nearest free charger for a robot that may charge, or the nearest of all if none is free.

        *bound* has the chargers to which robots are driving, by the robot's name.
        """
        chargers, here = self._setting.chargers[robot], self.point(robot)
        docked = {name: its.dock.name for name, its in self._roster.robots.items() if its.dock is not None}
        others = Counter(dock for name, dock in {**docked, **bound}.items() if name != robot)
        return min(
            chargers,
            key=lambda name: (
                others[name] >= chargers[name].capacity,
                self.seconds(robot, here, chargers[name].at),
                name,
            ),
        )


Doing = Literal["idle", "serves", "charges", "rests"]
"""The activity of a robot."""

REST: Final = 10.0
"""Seconds for which a robot rests after a failure."""

_PATIENCE: Final = 60.0
"""Seconds until a robot may get an order again with which it has failed."""

_BATCH: Final = 1_000
"""Events that are processed in one call."""

_WE: Final = "dispatcher"
_FULL: Final = (Comparison(("percentage",), ">=", CHARGED),)


Step: TypeAlias = tuple[str, "Message"]
"""The name of an action, and a goal."""


@dataclass(eq=False, slots=True)
class _Errand(Receiver):
    """A sequence of goals for one robot, which ends when one fails.

    Attributes:
        steps: The goals that are left, the next one last.
        then: Called when the errand ends, with whether all goals have succeeded; not called if the run ends first.
        end_step: Called from within the simulation with the errand and whether its present goal has succeeded.
    """

    robot: str
    steps: list[Step]
    then: Callable[[bool], None]
    end_step: Callable[[_Errand, bool], None]

    def succeed(self, answer: Any) -> None:
        """Take the response to a goal, or its result."""
        if type(answer) is ResultResponse:
            self.end_step(self, answer.status is GoalStatus.SUCCEEDED)
        elif not isinstance(answer, GoalResponse) or not answer.accepted:
            self.end_step(self, False)


class Run(SelectiveSink):
    """A run of a world that stops when a goal ends, a battery is charged, or an order arrives.

    Attributes:
        simulator: The simulator; read only.
    """

    def __init__(self, setting: Setting, seed: int, sinks: Sequence[Sink]) -> None:
        collect_runs_young()
        # No client asks for a result later.
        settings = RunSettings(seed=seed, keep_results=1)
        self.simulator = Simulator(setting.world, settings, [*sinks, self])
        self._env = self.simulator.env
        self._conditions = Conditions(self.simulator, self._stop)
        # The errands whose next goals are to be sent, and those whose goals have ended.
        self._next: list[_Errand] = []
        self._ended: list[tuple[_Errand, bool]] = []
        self._charging: dict[str, Callable[[], None]] = {}
        self._stopped = self._awaits_order = False
        self._placed = 0

    def handler_for(self, kind: type) -> Callable[[Any], object] | None:
        """Return the function that processes outputs of a type; None to ignore them."""
        if kind is OrdersChanged:
            return self._note_orders
        return (lambda _changed: self._conditions.follow()) if kind is RosterChanged else None

    def pursue(self, robot: str, steps: Sequence[Step], then: Callable[[bool], None]) -> None:
        """Send goals to a robot, each when the one before has succeeded, the first one before time moves on.

        *then* is called when one has failed or all have succeeded, with whether they have; not if the run ends first.
        """
        self._next.append(_Errand(robot, [*reversed(steps)], then, self._end_step))

    def await_order(self) -> None:
        """Stop when the next order arrives."""
        self._awaits_order = True

    def await_charge(self, robot: str, then: Callable[[], None]) -> None:
        """Stop when the battery of a robot is charged, and call a function."""
        self._charging[robot] = then
        self._conditions.watch(_WE, Watch(robot, Topic.BATTERY_STATE, robot, comparisons=_FULL))

    def advance(self, until: float) -> float:
        """Send the goals that are due, and let time pass until the run stops, at most until a given time.

        Returns:
            The time, in simulated seconds; all events of its instant are processed.
        """
        simulator, env, conditions = self.simulator, self._env, self._conditions
        errands, self._next = self._next, []
        self._stopped = bool(conditions.met)
        for errand in errands:
            action, goal = errand.steps.pop()
            simulator.submit(SendGoal(errand.robot, action, goal, reply_to=errand, result_to=errand), _WE)
        self._pass_time(until)
        if not self._stopped:
            simulator.advance_clock(until)
        return env.now if self._stopped else max(until, env.now)

    def take_ends(self) -> None:
        """Call the functions that wait for what has ended."""
        ended, self._ended = self._ended, []
        for errand, succeeded in ended:
            if succeeded and errand.steps:
                self._next.append(errand)
            else:
                errand.then(succeeded)
        if self._conditions.met:
            for robot in self._conditions.take_met(_WE):
                self._charging.pop(robot)()

    def _pass_time(self, until: float) -> None:
        """Process all events up to the end of the instant at which the run stops, or up to a given time."""
        process, env, conditions = self.simulator.process_events, self._env, self._conditions
        while True:
            end = env.now if self._stopped else until
            due = conditions.due if conditions.watched else math.inf
            if process(end_of_instant(min(end, due)), _BATCH):
                if self._stopped and due == math.inf and env.peek() > env.horizon:
                    return
            elif due == math.inf or end < due == conditions.due:
                return
            elif due == conditions.due:
                env.advance_clock(due)
                conditions.look()

    def close(self) -> None:
        """End all goals, and the run."""
        self.simulator.stop()

    def _stop(self) -> None:
        """Stop at the end of this instant."""
        self._stopped = True
        self.simulator.halt()

    def _end_step(self, errand: _Errand, succeeded: bool) -> None:  # noqa: FBT001 - the result of a goal
        self._ended.append((errand, succeeded))
        self._stopped = True
        self.simulator.halt()

    def _note_orders(self, _changed: OrdersChanged) -> None:
        before, self._placed = self._placed, self.simulator.demand.totals.placed
        if self._awaits_order and self._placed > before:
            self._awaits_order = False
            self._stop()


class Dispatching:
    """A run that pauses whenever a decision for a robot is needed; the caller closes it.

    Attributes:
        now: Simulated seconds.
        ended: Whether all orders have ended and no more will arrive.
        over: Whether there is nothing left to decide: all orders have ended, or the horizon is reached.
        truth: The actual state of robots and items.
        demand: The orders of the world; read only.
        free: The orders that no robot serves, in order of arrival.
        serving: The orders that robots serve, by the robot's name.
    """

    def __init__(self, setting: Setting, seed: int, sinks: Sequence[Sink] = ()) -> None:
        self._setting = setting
        self._run = Run(setting, seed, sinks)
        self.truth = Truth(self._run.simulator, setting)
        self.demand = self.truth.demand
        self.free: list[Order] = []
        self.serving: dict[str, Order] = {}
        self._doing: dict[str, Doing] = dict.fromkeys(setting.robots, "idle")
        self._waiting: dict[str, None] = {}
        self._charging: dict[str, str] = {}
        self._rests: dict[str, float] = {}
        self._failed: dict[tuple[str, str], float] = {}
        # When idle robots have to charge.
        self._low: dict[str, float] = {}
        self.now = 0.0
        self._go_on(0.0)

    def close(self) -> None:
        """End the run and its simulation."""
        self._run.close()

    @property
    def idle(self) -> list[str]:
        """The idle robots, in the world's order."""
        return [robot for robot, doing in self._doing.items() if doing == "idle"]

    @property
    def asking(self) -> list[str]:
        """The robots that need a decision, in the world's order."""
        if not self.free:
            return []
        waiting, failed = self._waiting, self._failed
        return [
            robot
            for robot, doing in self._doing.items()
            if doing == "idle" and robot not in waiting and not (failed and not self.choices(robot))
        ]

    def choices(self, robot: str) -> list[Order]:
        """Return the orders that a robot can choose from, in order of arrival."""
        if not self._failed:
            return self.free
        return [order for order in self.free if (robot, order.name) not in self._failed]

    def doing(self, robot: str) -> Doing:
        """Return the activity of a robot."""
        return self._doing[robot]

    def assign(self, robot: str, order: Order) -> None:
        """Make a robot serve a free order."""
        self.free = [each for each in self.free if each is not order]
        self.serving[robot] = order
        self._doing[robot] = "serves"
        there, to = self.truth.item_point(order), self.truth.destination(order)
        steps = [go(there), pick_up(order.item), go(to), put_down(order.item)]
        self._run.pursue(robot, steps, partial(self._served, robot, order))

    def wait(self, robot: str) -> None:
        """Make a robot wait until an order arrives or becomes free, or another robot becomes idle."""
        self._waiting[robot] = None

    def run_on(self) -> None:
        """Advance time until a robot needs a decision, or the run is over."""
        while not (self.over or self.asking):
            until = [self._setting.horizon, *self._rests.values(), *self._failed.values()]
            if idle := self.idle:
                self._run.await_order()
                until += [self._low[robot] for robot in idle]
            self._go_on(min(until))

    def _go_on(self, until: float) -> None:
        """Advance time until the next event, at most until a given time."""
        now = self.now = self._run.advance(until)
        self._run.take_ends()
        self.ended = self.demand.served
        self.over = self.ended or now >= self._setting.horizon
        if self._rests:
            self._end_rests()
        if self._failed:
            self._forget_failures()
        serving, before = {*self.serving.values()}, self.free
        self.free = [
            order for order in self.demand.open.values() if order.state is OrderState.WAITING and order not in serving
        ]
        if not all(map(before.__contains__, self.free)):
            self._waiting.clear()
        for robot, doing in self._doing.items():
            if doing == "idle":
                lasts = self.truth.lasts(robot)
                self._low[robot] = now + lasts
                if lasts < 0.0:
                    self._charge(robot)

    def _end_rests(self) -> None:
        now = self.now
        for robot in [robot for robot, end in self._rests.items() if end <= now]:
            del self._rests[robot]
            self._resume(robot)

    def _forget_failures(self) -> None:
        now = self.now
        if ended := [pair for pair, end in self._failed.items() if end <= now]:
            for pair in ended:
                del self._failed[pair]
            self._waiting.clear()

    def _become_idle(self, robot: str) -> None:
        self._doing[robot] = "idle"
        self._charging.pop(robot, None)
        self._waiting.clear()

    def _rest(self, robot: str) -> None:
        self._doing[robot] = "rests"
        self._rests[robot] = self.now + REST

    def _served(self, robot: str, order: Order, succeeded: bool) -> None:  # noqa: FBT001 - the result of an errand
        if succeeded:
            del self.serving[robot]
            self._become_idle(robot)
            return
        self._failed[robot, order.name] = self.now + _PATIENCE
        self._resume(robot)

    def _resume(self, robot: str) -> None:
        """Make a robot that has failed put down the item it carries, so that the order becomes free again."""
        order = self.serving.get(robot)
        if order is not None and self.truth.carries(robot, order):
            self._doing[robot] = "serves"
            self._run.pursue(robot, [put_down(order.item)], partial(self._put_down, robot))
        elif self.serving.pop(robot, None) is not None:
            self._rest(robot)
        else:
            self._become_idle(robot)

    def _put_down(self, robot: str, succeeded: bool) -> None:  # noqa: FBT001 - the result of an errand
        if succeeded:
            del self.serving[robot]
        self._rest(robot)

    def _charge(self, robot: str) -> None:
        nearest = self.truth.charger(robot, self._charging)
        self._doing[robot] = "charges"
        self._charging[robot] = nearest
        self._run.pursue(robot, [dock(nearest)], partial(self._docked, robot))

    def _docked(self, robot: str, succeeded: bool) -> None:  # noqa: FBT001 - the result of an errand
        if not succeeded:
            self._rest(robot)
            return
        self._run.await_charge(robot, partial(self._become_idle, robot))


_KEPT: Final = 4096
"""The number of goals of each action that are kept: validating them takes longer than executing them."""


@lru_cache(_KEPT)
def go(point: Point) -> Step:
    """Return the goal to drive to a point."""
    x, y = point
    return "navigate_to_pose", NavigateToPose.Goal(pose=PoseStamped(pose=Pose(position=PointMessage(x=x, y=y))))


@lru_cache(_KEPT)
def pick_up(item: str) -> Step:
    """Return the goal to pick up an item."""
    return "pickup", Pickup.Goal(target_name=item)


@lru_cache(_KEPT)
def put_down(item: str) -> Step:
    """Return the goal to put down an item at the robot's position."""
    return "place", Place.Goal(attached_object_name=item)


def dock(name: str) -> Step:
    """Return the goal to drive into a dock."""
    return "dock_robot", DockRobot.Goal(dock_id=name)
