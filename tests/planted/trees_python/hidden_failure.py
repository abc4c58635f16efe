"""A Fallback hides the failure of the pickup: the tree succeeds, and the parcel stays on the shelf."""

from py_trees.behaviour import Behaviour
from py_trees.behaviours import Success
from py_trees.composites import Selector, Sequence
from steps import bring, patient

from bt_controller.behaviours.robot_actions import GoTo, Pickup, Place


def mission(*, bug: bool = False) -> Behaviour:
    if not bug:
        return patient(bring("parcel", "ward"))
    # The bug: whatever fails, the rest goes on.
    pickup = Selector("Pick up, if possible", memory=True, children=[Pickup("parcel"), Success("Never mind")])
    place = Selector("Put down, if possible", memory=True, children=[Place("parcel"), Success("Nothing to do")])
    steps = [patient(step) for step in (GoTo("shelf"), pickup, GoTo("ward"), place)]
    return Sequence("Mission", memory=True, children=steps)
