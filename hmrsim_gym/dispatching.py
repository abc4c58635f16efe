"""A run of a world with orders: idle robots, free orders, and the goals with which robots serve them.

The robots are controlled by an ordinary client, with the goals that it would send to any simulator. The orders and
their states are read from the simulator itself.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Any, Final, Literal, TypeAlias

from hmrsim.actions import registry
from hmrsim.geometry import distance
from hmrsim.interfaces.geometry_msgs import Point as PointMessage
from hmrsim.interfaces.geometry_msgs import Pose, PoseStamped
from hmrsim.interfaces.moveit_msgs import Pickup, Place
from hmrsim.interfaces.nav2_msgs import DockRobot, NavigateToPose
from hmrsim.protocol.goal import GoalStatus
from hmrsim.settings.run import RunSettings
from hmrsim.simulation.demand import OrderState
from hmrsim.trials.local import LocalTrial
from hmrsim_gym.setting import CHARGED
from hmrsim_zenoh.client.conditions import Condition
from hmrsim_zenoh.errors import ClientClosed, SimulatorGone

if TYPE_CHECKING:
    from hmrsim.geometry import Point
    from hmrsim.interfaces.message import Message
    from hmrsim.protocol.sinks import Sink
    from hmrsim.simulation.demand import Demand, Order
    from hmrsim.simulation.simulator import Simulator
    from hmrsim_gym.setting import Setting
    from hmrsim_zenoh.client.client import Client
    from hmrsim_zenoh.client.goal_handle import GoalHandle
    from hmrsim_zenoh.client.lockstep import Lockstep
    from hmrsim_zenoh.errors import RequestError


class Truth:
    """Reads the state of a simulator without changing it.

    Attributes:
        demand: The orders of the world.
    """

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
        """Return the seconds until a robot has to charge at its present power; infinite if it never has to."""
        energy, now = self._roster.robots[robot].energy, self._env.now
        if energy is None or not self._setting.chargers[robot]:
            return math.inf
        flow, left = energy.battery.flow(now), energy.battery.share(now) - self._setting.charge_below
        # A whole second later, so that rounding can't leave it just above the limit.
        return math.floor(left * energy.battery.usable / -flow) + 1.0 if flow < 0 else math.inf

    def charger(self, robot: str, bound: Mapping[str, str]) -> str:
        """Return the nearest free charger for a robot, or the nearest of all if none is free.

        Args:
            robot: A robot that may charge.
            bound: The chargers to which robots are driving, by the robot's name.
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

_NAME: Final = "dispatcher"
_ARRIVAL: Final = Condition("_world/events", [("/kind", "==", "order_placed")])


class Dispatching:
    """A run that pauses whenever a decision for a robot is needed; the caller closes it.

    Args:
        setting: The setting that all episodes share.
        seed: The seed of the world.
        sinks: Further sinks of events.

    Attributes:
        now: Simulated seconds.
        truth: The actual state of robots and items.
        demand: The orders of the world; read only.
        free: The orders that no robot serves, in order of arrival.
        serving: The orders that robots serve, by the robot's name.
    """

    def __init__(self, setting: Setting, seed: int, sinks: Sequence[Sink] = ()) -> None:
        self._setting = setting
        self._trial = LocalTrial(setting.world, RunSettings(seed=seed), sinks=sinks)
        self._client = self._trial.open_client(_NAME)
        self._lockstep = _joined(self._client)
        self.truth = Truth(self._trial.simulator, setting)
        self.demand = self.truth.demand
        self.free: list[Order] = []
        self.serving: dict[str, Order] = {}
        self._doing: dict[str, Doing] = dict.fromkeys(setting.robots, "idle")
        self._waiting: dict[str, None] = {}
        self._charging: dict[str, str] = {}
        self._rests: dict[str, float] = {}
        self._failed: dict[tuple[str, str], float] = {}
        self._watching = False
        self.now = 0.0
        self._go_on(0.0)

    def close(self) -> None:
        """End the run."""
        self._trial.close()

    @property
    def ended(self) -> bool:
        """True if all orders have ended and no more will arrive."""
        return self.demand.served

    @property
    def over(self) -> bool:
        """True if there is nothing left to decide: all orders have ended, or the horizon is reached."""
        return self.now >= self._setting.horizon or self.demand.served

    @property
    def idle(self) -> list[str]:
        """The idle robots, in the world's order."""
        return [robot for robot, doing in self._doing.items() if doing == "idle"]

    @property
    def asking(self) -> list[str]:
        """The robots that need a decision, in the world's order."""
        if not self.free:
            return []
        waiting = self._waiting
        return [
            robot
            for robot, doing in self._doing.items()
            if doing == "idle" and robot not in waiting and self.choices(robot)
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
        Errand(self._client, robot, steps, partial(self._served, robot, order)).go_on()

    def wait(self, robot: str) -> None:
        """Make a robot wait until an order arrives or becomes free, or another robot becomes idle."""
        self._waiting[robot] = None

    def run_on(self) -> None:
        """Let time pass until a robot needs a decision, or the run is over."""
        while not (self.over or self.asking):
            until = [self._setting.horizon, *self._rests.values(), *self._failed.values()]
            if idle := self.idle:
                if not self._watching:
                    self._watching = True
                    self._lockstep.watch(_ARRIVAL, self._note_order)
                until.append(self.now + min(map(self.truth.lasts, idle)))
            self._go_on(min(until))

    def _go_on(self, until: float) -> None:
        """Let time pass until something happens, at most until a given time."""
        self._lockstep.advance(until=until)
        self.now = self._lockstep.now
        if self._rests:
            self._end_rests()
        if self._failed:
            self._forget_failures()
        serving, before = self.serving.values(), self.free
        self.free = [
            order for order in self.demand.open.values() if order.state is OrderState.WAITING and order not in serving
        ]
        if not all(map(before.__contains__, self.free)):
            self._waiting.clear()
        for robot, doing in self._doing.items():
            if doing == "idle":
                self._charge_if_low(robot)

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

    def _note_order(self, _error: RequestError | None) -> None:
        self._watching = False

    def _become_idle(self, robot: str) -> None:
        self._doing[robot] = "idle"
        self._charging.pop(robot, None)
        self._waiting.clear()

    def _rest(self, robot: str) -> None:
        self._doing[robot] = "rests"
        self._rests[robot] = self._lockstep.now + REST

    def _served(self, robot: str, order: Order, succeeded: bool) -> None:  # noqa: FBT001 - the result of an errand
        if succeeded:
            del self.serving[robot]
            self._become_idle(robot)
            return
        self._failed[robot, order.name] = self._lockstep.now + _PATIENCE
        self._resume(robot)

    def _resume(self, robot: str) -> None:
        """Make a robot that has failed put down the item it carries, so that the order becomes free again."""
        order = self.serving.get(robot)
        if order is not None and self.truth.carries(robot, order):
            self._doing[robot] = "serves"
            Errand(self._client, robot, [put_down(order.item)], partial(self._put_down, robot)).go_on()
        elif self.serving.pop(robot, None) is not None:
            self._rest(robot)
        else:
            self._become_idle(robot)

    def _put_down(self, robot: str, succeeded: bool) -> None:  # noqa: FBT001 - the result of an errand
        if succeeded:
            del self.serving[robot]
        self._rest(robot)

    def _charge_if_low(self, robot: str) -> None:
        if not self._setting.chargers[robot] or self.truth.battery(robot) >= self._setting.charge_below:
            return
        nearest = self.truth.charger(robot, self._charging)
        self._doing[robot] = "charges"
        self._charging[robot] = nearest
        Errand(self._client, robot, [dock(nearest)], partial(self._docked, robot)).go_on()

    def _docked(self, robot: str, succeeded: bool) -> None:  # noqa: FBT001 - the result of an errand
        if not succeeded:
            self._rest(robot)
            return
        full = Condition(f"{robot}/battery_state", [("/percentage", ">=", CHARGED)])
        self._lockstep.watch(full, lambda _error: self._become_idle(robot))


def _joined(client: Client) -> Lockstep:
    lockstep = client.lockstep
    if lockstep is None:
        raise AssertionError
    return lockstep


Step: TypeAlias = tuple[str, "Message"]
"""The name of an action, and a goal."""

_KEPT: Final = 4096
"""The number of goals to drive that are kept."""
_PICKUP, _PLACE = Pickup.Goal(), Place.Goal()


class Errand:
    """A sequence of goals for one robot, which ends when one fails.

    Args:
        client: The client that sends the goals.
        robot: The robot.
        steps: At least one step.
        then: Called when the errand ends, with whether all goals have succeeded; not called if the run ends first.
    """

    def __init__(self, client: Client, robot: str, steps: Sequence[Step], then: Callable[[bool], None]) -> None:
        self._client = client
        self._robot = robot
        self._left = iter(steps)
        self._then = then

    def go_on(self) -> None:
        """Send the next goal, or report that all have succeeded."""
        step = next(self._left, None)
        if step is None:
            self._then(True)
            return
        action = self._client.action_client(self._robot, registry()[step[0]])
        action.send_goal(step[1], read_result=False, on_change=self._note_change)

    def _note_change(self, goal: GoalHandle[Any, Any]) -> None:
        if not goal.done:
            return
        if goal.status is GoalStatus.SUCCEEDED:
            self.go_on()
        elif not isinstance(goal.error, ClientClosed | SimulatorGone):
            self._then(False)


@lru_cache(_KEPT)
def go(point: Point) -> Step:
    """Return the goal to drive to a point."""
    x, y = point
    return "navigate_to_pose", NavigateToPose.Goal(pose=PoseStamped(pose=Pose(position=PointMessage(x=x, y=y))))


def pick_up(item: str) -> Step:
    """Return the goal to pick up an item."""
    # Copies are not validated: large messages would take most of the time of a decision.
    return "pickup", _PICKUP.model_copy(update={"target_name": item})


def put_down(item: str) -> Step:
    """Return the goal to put down an item at the robot's position."""
    return "place", _PLACE.model_copy(update={"attached_object_name": item})


def dock(name: str) -> Step:
    """Return the goal to drive into a dock."""
    return "dock_robot", DockRobot.Goal(dock_id=name)
