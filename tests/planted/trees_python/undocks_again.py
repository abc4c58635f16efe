"""A repeated mission begins with undocking, which fails where the robot is after a failure."""

from py_trees.behaviour import Behaviour
from py_trees.behaviours import Success
from py_trees.composites import Selector, Sequence
from steps import patient

from bt_controller.behaviours.robot_actions import GoTo, Undock


def mission(*, bug: bool = False) -> Behaviour:
    undock: Behaviour = Undock()
    if not bug:  # the bug: undocking has to succeed
        undock = Selector("Be free", memory=True, children=[undock, Success("Was not docked")])
    steps = [undock, GoTo("ward_a"), GoTo("ward_b")]
    return patient(Sequence("Rounds", memory=True, children=steps))
