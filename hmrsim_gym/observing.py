"""Observations: what a robot that asks can know, and the orders that it may choose from."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from hmrsim_gym.features import FAR, MOST, FleetFeature, Mask, Observation, OrderFeature, RobotFeature

if TYPE_CHECKING:
    from collections.abc import Sequence

    from hmrsim.simulation.orders import Order
    from hmrsim_gym.dispatching import Dispatching
    from hmrsim_gym.setting import Setting

_MINUTE: Final = 60.0


class Observer:
    """Observes runs of one setting."""

    def __init__(self, setting: Setting) -> None:
        self._setting = setting
        corners = [*setting.world.points.values()]
        self._left, self._width = _extent([x for x, _ in corners])
        self._lower, self._height = _extent([y for _, y in corners])

    def choices(self, run: Dispatching, robot: str) -> list[Order]:
        """Return the orders that a robot may choose from, the nearest first.

        Where there are more than an observation has room for, half of them are the nearest ones, and the others those
        of the rest that are due first.
        """
        most = self._setting.orders
        here = run.truth.point(robot)
        near = sorted(run.choices(robot), key=lambda order: run.truth.seconds(robot, here, run.truth.item_point(order)))
        if len(near) <= most:
            return near
        half = most // 2
        rest = sorted(near[half:], key=lambda order: (FAR * FAR if order.due is None else order.due, order.placed))
        chosen = [order.name for order in (*near[:half], *rest[: most - half])]
        return [order for order in near if order.name in chosen]

    def observe(self, run: Dispatching, robot: str, choices: Sequence[Order]) -> Observation:
        """Return what a robot can know, with a row for each of its choices; without any it can only wait."""
        most, now = self._setting.orders, run.now
        here, idle = run.truth.point(robot), run.idle
        others = [other for other in idle if other != robot]
        orders = np.zeros((most, len(OrderFeature)), np.float32)
        for row, order in enumerate(choices):
            orders[row] = _row(run, order, robot, others)
        late = sum([order.late for order in run.demand.open.values()])
        seen = [0.0] * len(FleetFeature)
        seen[FleetFeature.TIME] = now / self._setting.horizon
        seen[FleetFeature.BACKLOG] = min(len(run.free), MOST)
        seen[FleetFeature.LATE] = min(late, MOST)
        seen[FleetFeature.IDLE] = len(idle)
        itself = [0.0] * len(RobotFeature)
        itself[RobotFeature.X] = (here[0] - self._left) / self._width
        itself[RobotFeature.Y] = (here[1] - self._lower) / self._height
        itself[RobotFeature.BATTERY] = run.truth.battery(robot)
        return {
            "robot": np.array(itself, np.float32),
            "orders": orders,
            "fleet": np.array(seen, np.float32),
            "action_mask": mask(most, len(choices)),
        }


def mask(most: int, choices: int) -> Mask:
    """Return which actions are there: each of the choices, and to wait, which is the last one."""
    allowed = np.zeros(most + 1, np.int8)
    allowed[:choices] = 1
    allowed[most] = 1
    return allowed


def _row(run: Dispatching, order: Order, robot: str, others: Sequence[str]) -> list[float]:
    item, now = run.truth.item_point(order), run.now
    approach = run.truth.seconds(robot, run.truth.point(robot), item)
    rival = min([run.truth.seconds(other, run.truth.point(other), item) for other in others], default=None)
    row = [0.0] * len(OrderFeature)
    row[OrderFeature.VALID] = 1.0
    row[OrderFeature.APPROACH] = _minutes(approach)
    row[OrderFeature.TRIP] = _minutes(run.truth.seconds(robot, item, run.truth.destination(order)))
    row[OrderFeature.AGE] = _minutes(now - order.placed)
    row[OrderFeature.SLACK] = FAR if order.due is None else _minutes(order.due - now)
    row[OrderFeature.PRIORITY] = min(max(order.priority, -MOST), MOST)
    row[OrderFeature.RIVAL] = FAR if rival is None else _minutes(rival - approach)
    return row


def _minutes(seconds: float) -> float:
    return min(max(seconds / _MINUTE, -FAR), FAR)


def _extent(values: Sequence[float]) -> tuple[float, float]:
    """Return the least of some coordinates, and how far it is to the greatest; 1 where they are all the same."""
    return min(values), max(values) - min(values) or 1.0
