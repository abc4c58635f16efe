"""Read a meter, then dock and charge; a docked robot waits before it is sent into its dock again."""

from py_trees.composites import Selector, Sequence
from py_trees.decorators import Inverter, Retry
from py_trees.timers import Timer

from bt_controller.behaviours.battery import WaitUntilCharged
from bt_controller.behaviours.robot_actions import Dock, GoTo, Wait


def read_meter():
    """Return the tree of the robot."""
    charge = Sequence("Dock and charge", memory=True, children=[Dock("charger"), WaitUntilCharged(0.9)])
    pause = Inverter("Not yet", Timer("Pause", duration=30.0))
    attempt = Selector("Charge or pause", memory=True, children=[charge, pause])
    return Sequence(
        "Read the meter", memory=True, children=[GoTo("meter"), Wait(5), Retry("Charge", attempt, num_failures=20)]
    )
