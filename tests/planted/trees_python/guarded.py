"""The rounds, and a check with a charge before each drive, shared by trees that look at the battery."""

import operator
from collections.abc import Callable
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.composites import Selector, Sequence

from bt_controller.behaviours.battery import WaitUntilCharged
from bt_controller.behaviours.robot_actions import Dock
from bt_controller.behaviours.subscribers import CheckData

ROUNDS = ("ward_a", "ward_b", "ward_c", "ward_b", "ward_a", "home") * 2
LEAST = 0.4
"""The charge that is enough for a drive to the next ward, and from there to the charger."""


def enough(name: str, least: float = LEAST, compare: Callable[[Any, Any], bool] = operator.ge) -> Behaviour:
    """Return a check of the battery, which is charged if it is too low."""
    check = CheckData(f"{name}: enough", "battery_state", "percentage", least, compare, fail_if_bad_comparison=True)
    charge = Sequence(f"{name}: charge", memory=True, children=[Dock("charger"), WaitUntilCharged(0.9)])
    return Selector(f"{name}: battery", memory=True, children=[check, charge])
