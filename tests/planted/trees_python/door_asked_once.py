"""The door is opened once, and a robot waits forever before a door that was jammed then."""

from doors import WaitUntilOpen, ask_to_open
from py_trees.behaviour import Behaviour
from py_trees.behaviours import Success
from py_trees.composites import Selector, Sequence
from py_trees.decorators import Timeout
from steps import patient

from bt_controller.behaviours.robot_actions import GoTo


def mission(*, bug: bool = False) -> Behaviour:
    if bug:  # the bug: a refusal is not noticed, and the wait has no limit
        ask = Selector("Ask", memory=True, children=[ask_to_open("gate"), Success("It will open")])
        steps = [ask, WaitUntilOpen("gate"), patient(GoTo("ward"))]
    else:
        wait = Timeout("At most 20 s", WaitUntilOpen("gate"), 20.0)
        steps = [patient(Sequence("Pass", memory=True, children=[ask_to_open("gate"), wait, GoTo("ward")]))]
    return Sequence("Mission", memory=True, children=[patient(GoTo("lobby")), *steps])
