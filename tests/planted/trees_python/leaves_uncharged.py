"""The robot leaves its charger when docking has succeeded, and not when it is charged."""

from guarded import LEAST, ROUNDS
from py_trees.behaviour import Behaviour
from py_trees.composites import Selector, Sequence
from py_trees.decorators import Inverter
from steps import patient

from bt_controller.behaviours.battery import WaitUntilCharged
from bt_controller.behaviours.robot_actions import Dock, GoTo
from bt_controller.core.port_values import node
from bt_controller.nodes.conditions.robot import IsBatteryLow


def mission(*, bug: bool = False) -> Behaviour:
    drives: list[Behaviour] = []
    for number, place in enumerate(ROUNDS):
        low = Inverter(f"{number}: enough", node(IsBatteryLow, min_battery=LEAST))
        charge = [Dock("charger"), *([] if bug else [WaitUntilCharged(0.9)])]  # the bug: it does not wait
        steps = Sequence(f"{number}: charge", memory=True, children=charge)
        battery = Selector(f"{number}: battery", memory=True, children=[low, steps])
        go = GoTo(place, name=f"{number}: go to {place}")
        drives.append(patient(Sequence(f"Round {number}", memory=True, children=[battery, go])))
    return Sequence("Rounds", memory=True, children=drives)
