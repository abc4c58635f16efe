"""A Selector without memory ticks its first child again during the recovery, which ends its wait."""

from py_trees.behaviour import Behaviour
from py_trees.composites import Selector, Sequence
from py_trees.decorators import SuccessIsFailure
from py_trees.timers import Timer
from steps import ATTEMPTS, PAUSE

from bt_controller.behaviours.robot_actions import GoTo


def mission(*, bug: bool = False) -> Behaviour:
    """Return the tree that visits two wards, with a wait and another attempt after a failure."""
    memory = not bug  # the bug: without memory the drive is tried at each tick
    return Sequence("Rounds", memory=True, children=[_drive("ward_a", memory), _drive("ward_b", memory)])


def _drive(place: str, memory: bool) -> Behaviour:  # noqa: FBT001 - of py_trees
    tries: list[Behaviour] = []
    for number in range(1, ATTEMPTS + 1):
        tries.append(GoTo(place, name=f"Go to {place}, try {number}"))
        if number < ATTEMPTS:
            tries.append(_pause(f"Wait before going to {place}, {number}"))
    return Selector(f"Reach {place}", memory=memory, children=tries)


def _pause(name: str) -> Behaviour:
    return SuccessIsFailure(name, Timer(f"{name}: timer", PAUSE))
