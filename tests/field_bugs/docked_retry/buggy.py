"""Read a meter, then dock and charge; docking is tried again until the battery is charged."""

from py_trees.composites import Sequence
from py_trees.decorators import Retry

from bt_controller.behaviours.battery import WaitUntilCharged
from bt_controller.behaviours.robot_actions import Dock, GoTo, Wait


def read_meter():
    """Return the tree of the robot."""
    charge = Sequence("Dock and charge", memory=True, children=[Dock("charger"), WaitUntilCharged(0.9)])
    return Sequence(
        "Read the meter", memory=True, children=[GoTo("meter"), Wait(5), Retry("Charge", charge, num_failures=20)]
    )
