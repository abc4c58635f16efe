"""The robot waits for the event that the door opens, which never comes if it is open already."""

from doors import WaitForOpening, WaitUntilOpen, ask_to_open
from py_trees.behaviour import Behaviour
from py_trees.composites import Sequence
from py_trees.decorators import Timeout
from steps import patient

from bt_controller.behaviours.robot_actions import GoTo


def mission(*, bug: bool = False) -> Behaviour:
    ask = patient(ask_to_open("gate"))
    if bug:  # the bug: it waits for a change, and not for a state
        steps = [patient(GoTo("lobby")), ask, WaitForOpening("gate"), patient(GoTo("ward"))]
    else:
        wait = Timeout("At most 20 s", WaitUntilOpen("gate"), 20.0)
        through = Sequence("Pass", memory=True, children=[ask_to_open("gate"), wait, GoTo("ward")])
        steps = [patient(GoTo("lobby")), patient(through)]
    return Sequence("Mission", memory=True, children=steps)
