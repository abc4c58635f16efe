"""A charged robot stays in the only berth, and the other one queues until its battery is empty."""

from py_trees.behaviour import Behaviour
from py_trees.composites import Selector, Sequence
from py_trees.decorators import Inverter
from steps import patient

from bt_controller.behaviours.battery import WaitUntilCharged
from bt_controller.behaviours.robot_actions import Dock, GoTo, Wait
from bt_controller.core.port_values import node
from bt_controller.nodes.conditions.robot import IsBatteryLow

WARDS = {"wall_e": "ward_a", "eve": "ward_b"}


def mission(robot: str, *, bug: bool = False) -> Behaviour:
    """Return the tree of one of two robots, which works in its ward, charges if necessary, and works again."""
    ward = WARDS[robot]
    low = Inverter("Enough", node(IsBatteryLow, min_battery=0.5))
    charge = Sequence("Charge", memory=True, children=[Dock("charger"), WaitUntilCharged(0.9)])
    battery = Selector("Battery", memory=True, children=[low, charge])
    parts = [patient(GoTo(ward)), patient(Wait(20)), patient(battery)]
    if not bug:  # the bug: it stays where it has charged
        parts.append(patient(GoTo("home" if robot == "wall_e" else "yard")))
    return Sequence("Mission", memory=True, children=parts)
