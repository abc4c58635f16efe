"""What an observation has: its arrays, the columns of each, and their space."""

from __future__ import annotations

from enum import IntEnum
from typing import Any, Final, TypeAlias

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float32]
Mask: TypeAlias = NDArray[np.int8]
Observation: TypeAlias = dict[str, NDArray[Any]]

FAR: Final = 60.0
"""Minutes that stand for never, and for all that is longer."""

MOST: Final = 1000.0
"""The greatest number of anything that is counted."""


class RobotFeature(IntEnum):
    """Columns of ``robot``: where it is, as shares of the map's width and height, and the share of its battery."""

    X = 0
    Y = 1
    BATTERY = 2


class OrderFeature(IntEnum):
    """Columns of ``orders``, all times in minutes.

    ``APPROACH`` is the robot's way to the item and ``TRIP`` that from there to the destination, by route at the robot's
    greatest speed; ``AGE`` counts from when the order came, ``SLACK`` until it is due, `FAR` if never. ``RIVAL`` is by
    how much longer the other idle robot that is nearest has to the item, less than 0 if that one is nearer, `FAR`
    without one. A row that is no order is all 0, ``VALID`` included.
    """

    VALID = 0
    APPROACH = 1
    TRIP = 2
    AGE = 3
    SLACK = 4
    PRIORITY = 5
    RIVAL = 6


class FleetFeature(IntEnum):
    """Columns of ``fleet``: the share of the horizon that has passed, and numbers of orders and of idle robots.

    ``BACKLOG`` counts the orders that nobody serves, ``LATE`` all open orders that are late.
    """

    TIME = 0
    BACKLOG = 1
    LATE = 2
    IDLE = 3


def observation_space(orders: int) -> spaces.Dict:
    """Return the space of observations with so many orders."""

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
