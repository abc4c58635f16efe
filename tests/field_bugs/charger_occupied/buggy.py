"""Count the stock, and go to one's own charger, or else to that of the other robot."""

from py_trees.composites import Selector, Sequence
from py_trees.decorators import Retry

from bt_controller.behaviours.robot_actions import Dock, GoTo, Wait

CHARGERS = {"eve": ("charger_1", "charger_2"), "wall_e": ("charger_2", "charger_1")}


def count(robot):
    """Return the tree of one robot."""
    own, other = CHARGERS[robot]
    charge = Selector("Charge", memory=True, children=[Dock(own), Dock(other)])
    return Sequence("Count", memory=True, children=[Retry("Drive", GoTo("middle"), 3), Wait(5), charge])
