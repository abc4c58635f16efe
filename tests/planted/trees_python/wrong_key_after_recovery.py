"""The recovery drives home with the key of the mission's destination, and does not restore it."""

from py_trees.behaviour import Behaviour
from py_trees.behaviours import Failure, SetBlackboardVariable
from py_trees.composites import Selector, Sequence
from py_trees.decorators import Retry
from py_trees.timers import Timer
from steps import GoToItem, Holds, patient

from bt_controller.behaviours.action_clients import FromBlackboard
from bt_controller.behaviours.robot_actions import Pickup, Place, pose_goal
from hmrsim.actions.navigate_to_pose import ACTION

WARD, HALL = pose_goal(18.0, 0.0), pose_goal(12.0, 0.0)


def mission(*, bug: bool = False) -> Behaviour:
    """Return the tree that brings the parcel to the destination, and rests in the hall after a failure."""
    key = "destination" if bug else "resting_place"  # the bug: the recovery's key
    rest = [
        Timer("Repair", 20.0),
        _note("Note where to rest", key, HALL),
        FromBlackboard("Go and rest", ACTION, key),
        Failure("Again"),
    ]
    drive = Selector(
        "Drive, or rest",
        memory=True,
        children=[
            FromBlackboard("Go to the destination", ACTION, "destination"),
            Sequence("Rest", memory=True, children=rest),
        ],
    )
    fetch = Sequence("Fetch", memory=True, children=[GoToItem("parcel"), Pickup("parcel")])
    have = Selector("Have the parcel", memory=True, children=[Holds("parcel"), fetch])
    bring = [have, Retry("Reach it", drive, 10), Place("parcel")]
    steps = [
        _note("Note the destination", "destination", WARD),
        patient(Sequence("Bring", memory=True, children=bring)),
    ]
    return Sequence("Mission", memory=True, children=steps)


def _note(name: str, key: str, value: object) -> Behaviour:
    return SetBlackboardVariable(name, key, value, overwrite=True)
