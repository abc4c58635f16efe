"""A run of a world with orders: who is idle, which orders are free, and what robots do with those they are given.

An outside client over the loopback drives the robots, by the goals that clients of any simulator send. What there is to
do, and what has become of it, is the truth of the world: its demand.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Final, Literal

from hmrsim.settings.run import RunSettings
from hmrsim.simulation.orders import OrderState
from hmrsim.trials.local import LocalTrial
from hmrsim_gym.errand import dock, go, pick_up, put_down, send
from hmrsim_gym.setting import CHARGED
from hmrsim_gym.truth import Truth
from hmrsim_zenoh.client.conditions import Condition

if TYPE_CHECKING:
    from collections.abc import Sequence

    from hmrsim.protocol.sinks import Sink
    from hmrsim.simulation.orders import Order
    from hmrsim_gym.setting import Setting
    from hmrsim_zenoh.client.client import Client
    from hmrsim_zenoh.client.lockstep import Lockstep
    from hmrsim_zenoh.errors import RequestError

Doing = Literal["idle", "serves", "charges", "rests"]
"""What a robot does."""

REST: Final = 10.0
"""Seconds for which a robot that has failed is given nothing."""

_PATIENCE: Final = 60.0
"""Seconds for which it is not given the order with which it has failed."""

_NAME: Final = "dispatcher"
_COMES: Final = Condition("_world/events", [("/kind", "==", "order_placed")])


class Dispatching:
    """A run that stands still whenever a robot has to be told what to do; the caller closes it.

    Args:
        setting: What episodes have in common.
        seed: The seed of the world.
        sinks: Further sinks of events.

    Attributes:
        now: Simulated seconds.
        truth: What is true in it.
        demand: The orders of the world; to be read only.
        free: The orders that nobody serves, in the order in which they came.
        serving: Who serves which order, by the robot's name.
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
        """Whether all orders have ended and none will come."""
        return self.demand.served

    @property
    def over(self) -> bool:
        """Whether there is nothing more to decide: all orders have ended, or the horizon is reached."""
        return self.ended or self.now >= self._setting.horizon

    @property
    def idle(self) -> list[str]:
        """The robots that have nothing to do, in the world's order."""
        return [robot for robot, doing in self._doing.items() if doing == "idle"]

    @property
    def asking(self) -> list[str]:
        """The robots that have to be told what to do, in the world's order."""
        if not self.free:
            return []
        return [robot for robot in self.idle if robot not in self._waiting and self.choices(robot)]

    def choices(self, robot: str) -> list[Order]:
        """Return the orders that a robot may be given, in the order in which they came."""
        if not self._failed:
            return self.free
        return [order for order in self.free if (robot, order.name) not in self._failed]

    def doing(self, robot: str) -> Doing:
        """Return what a robot does."""
        return self._doing[robot]

    def assign(self, robot: str, order: Order) -> None:
        """Have a robot that asks serve an order that is free."""
        self.free = [each for each in self.free if each is not order]
        self.serving[robot] = order
        self._doing[robot] = "serves"
        there, to = self.truth.item_point(order), self.truth.destination(order)
        steps = [go(there), pick_up(order.item), go(to), put_down(order.item)]
        send(self._client, robot, steps, partial(self._served, robot, order))

    def wait(self, robot: str) -> None:
        """Have a robot wait until an order comes or becomes free, or another robot becomes idle."""
        self._waiting[robot] = None

    def run_on(self) -> None:
        """Let time go on until a robot asks, or it is over."""
        while not (self.over or self.asking):
            until = [self._setting.horizon, *self._rests.values(), *self._failed.values()]
            if idle := self.idle:
                if not self._watching:
                    self._watching = True
                    self._lockstep.watch(_COMES, self._note_order)
                until.append(self.now + min(map(self.truth.lasts, idle)))
            self._go_on(min(until))

    def _go_on(self, until: float) -> None:
        """Let time go on until something happens, or until then."""
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
        for robot in self.idle:
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

    def _served(self, robot: str, order: Order, succeeded: bool) -> None:  # noqa: FBT001 - what an errand tells
        if succeeded:
            del self.serving[robot]
            self._become_idle(robot)
            return
        self._failed[robot, order.name] = self._lockstep.now + _PATIENCE
        self._resume(robot)

    def _resume(self, robot: str) -> None:
        """Have a robot that has failed lay down what it carries still, so that the order becomes free again."""
        order = self.serving.get(robot)
        if order is not None and self.truth.carries(robot, order):
            self._doing[robot] = "serves"
            send(self._client, robot, [put_down(order.item)], partial(self._laid, robot))
        elif self.serving.pop(robot, None) is not None:
            self._rest(robot)
        else:
            self._become_idle(robot)

    def _laid(self, robot: str, succeeded: bool) -> None:  # noqa: FBT001 - what an errand tells
        if succeeded:
            del self.serving[robot]
        self._rest(robot)

    def _charge_if_low(self, robot: str) -> None:
        if not self.truth.may_charge(robot) or self.truth.battery(robot) >= self._setting.charge_below:
            return
        nearest = self.truth.charger(robot, self._charging)
        self._doing[robot] = "charges"
        self._charging[robot] = nearest
        send(self._client, robot, [dock(nearest)], partial(self._docked, robot))

    def _docked(self, robot: str, succeeded: bool) -> None:  # noqa: FBT001 - what an errand tells
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
