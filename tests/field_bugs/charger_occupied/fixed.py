"""Count the stock, and go to one of the chargers, rather one's own, whichever is free."""

from py_trees.composites import Selector, Sequence
from py_trees.decorators import Inverter, Retry
from py_trees.timers import Timer

from bt_controller.behaviours.robot_actions import Dock, GoTo, Wait

CHARGERS = {"eve": ("charger_1", "charger_2"), "wall_e": ("charger_2", "charger_1")}


def count(robot):
    """Return the tree of one robot."""
    attempts = [Dock(dock, max_staging_time=40.0) for dock in CHARGERS[robot]]
    pause = Inverter("Not yet", Timer("Pause", duration=25.0))
    charge = Selector("Charge", memory=True, children=[*attempts, pause])
    return Sequence(
        "Count", memory=True, children=[Retry("Drive", GoTo("middle"), 3), Wait(5), Retry("Until charged", charge, 8)]
    )
