"""Observations: their arrays, columns and space, the observer that makes them, and rules that decide by them.

A rule returns the action for an observation, and never waits while there is an order.
"""

from __future__ import annotations

from enum import IntEnum
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

if TYPE_CHECKING:
    from collections.abc import Sequence

    from hmrsim.simulation.demand import Order
    from hmrsim_gym.dispatching import Dispatching
    from hmrsim_gym.setting import Setting

Array: TypeAlias = NDArray[np.float32]
Mask: TypeAlias = NDArray[np.int8]
Observation: TypeAlias = dict[str, NDArray[Any]]

FAR: Final = 60.0
"""The longest time in minutes, which also stands for never."""

MOST: Final = 1000.0
"""The greatest value of a count or priority."""


class RobotFeature(IntEnum):
    """Columns of ``robot``: position as shares of the map's width and height, and the charge of its battery."""

    X = 0
    Y = 1
    BATTERY = 2


class OrderFeature(IntEnum):
    """Columns of ``orders``, all times in minutes.

    ``APPROACH`` is the travel time to the item, and ``TRIP`` the time from there to the destination, along the route at
    the robot's maximum speed. ``AGE`` is the time since the order arrived, ``SLACK`` the time until it is due, `FAR` if
    never. ``RIVAL`` is how much longer the nearest other idle robot takes to the item: negative if it is nearer, `FAR`
    if there is none. Unused rows are 0, including ``VALID``.
    """

    VALID = 0
    APPROACH = 1
    TRIP = 2
    AGE = 3
    SLACK = 4
    PRIORITY = 5
    RIVAL = 6


class FleetFeature(IntEnum):
    """Columns of ``fleet``: the share of the horizon that has passed, and counts of orders and idle robots.

    ``BACKLOG`` counts the orders that no robot serves, ``LATE`` all open orders that are late.
    """

    TIME = 0
    BACKLOG = 1
    LATE = 2
    IDLE = 3


def observation_space(orders: int) -> spaces.Dict:
    """Return the space of observations with a number of order rows."""

    def box(*shape: int) -> spaces.Box:
        return spaces.Box(-MOST, MOST, shape, np.float32)

    return spaces.Dict(
        {
            "robot": box(len(RobotFeature)),
            "orders": box(orders, len(OrderFeature)),
            "fleet": box(len(FleetFeature)),
            "action_mask": spaces.Box(0, 1, (orders + 1,), np.int8),
        }
    )


_MINUTE: Final = 60.0


class Observer:
    """Makes observations of runs with one setting."""

    def __init__(self, setting: Setting) -> None:
        self._setting = setting
        corners = [*setting.world.points.values()]
        self._left, self._width = _extent([x for x, _ in corners])
        self._lower, self._height = _extent([y for _, y in corners])

    def choices(self, run: Dispatching, robot: str) -> list[Order]:
        """Return the orders that a robot can choose from, the nearest first.

        If there are more than an observation has rows, half of the rows are for the nearest orders, and the others for
        those of the rest that are due first.
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
        """Return the observation of a robot, with a row for each of its choices; without any it can only wait."""
        most, now = self._setting.orders, run.now
        here, idle = run.truth.point(robot), run.idle
        others = [other for other in idle if other != robot]
        orders = np.zeros((most, len(OrderFeature)), np.float32)
        for row, order in enumerate(choices):
            orders[row] = _row(run, order, robot, others)
        late = sum([order.late for order in run.demand.open.values()])
        # In the order of RobotFeature and FleetFeature.
        x, y = (here[0] - self._left) / self._width, (here[1] - self._lower) / self._height
        fleet = [now / self._setting.horizon, min(len(run.free), MOST), min(late, MOST), len(idle)]
        return {
            "robot": np.array([x, y, run.truth.battery(robot)], np.float32),
            "orders": orders,
            "fleet": np.array(fleet, np.float32),
            "action_mask": mask(most, len(choices)),
        }


def mask(most: int, choices: int) -> Mask:
    """Return the valid actions: one for each choice, and the last one, which is to wait."""
    allowed = np.zeros(most + 1, np.int8)
    allowed[:choices] = 1
    allowed[most] = 1
    return allowed


def _row(run: Dispatching, order: Order, robot: str, others: Sequence[str]) -> list[float]:
    item, now = run.truth.item_point(order), run.now
    approach = run.truth.seconds(robot, run.truth.point(robot), item)
    rival = min([run.truth.seconds(other, run.truth.point(other), item) for other in others], default=None)
    # In the order of OrderFeature.
    return [
        1.0,
        _minutes(approach),
        _minutes(run.truth.seconds(robot, item, run.truth.destination(order))),
        _minutes(now - order.placed),
        FAR if order.due is None else _minutes(order.due - now),
        min(max(order.priority, -MOST), MOST),
        FAR if rival is None else _minutes(rival - approach),
    ]


def _minutes(seconds: float) -> float:
    return min(max(seconds / _MINUTE, -FAR), FAR)


def _extent(values: Sequence[float]) -> tuple[float, float]:
    """Return the minimum of coordinates and their range, which is 1 if they are all equal."""
    return min(values), max(values) - min(values) or 1.0


def nearest(observation: Observation) -> int:
    """Return the action for the order whose item the robot reaches first."""
    return best(observation, -observation["orders"][:, OrderFeature.APPROACH])


def first_come(observation: Observation) -> int:
    """Return the action for the oldest order."""
    return best(observation, observation["orders"][:, OrderFeature.AGE])


def earliest_due(observation: Observation) -> int:
    """Return the action for the order that is due first."""
    return best(observation, -observation["orders"][:, OrderFeature.SLACK])


def best(observation: Observation, scores: Array, waiting: float | None = None) -> int:
    """Return the action for the order with the highest score, the first one if several are equal.

    *scores* has a score for each row of orders, and *waiting* is the score of waiting; None to never wait.
    """
    wait = len(scores)
    count = int(observation["action_mask"][:wait].sum())
    if not count:
        return wait
    row = int(scores[:count].argmax())
    return wait if waiting is not None and waiting > scores[row] else row
