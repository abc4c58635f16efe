"""The battery is checked once before the rounds, and not before each drive."""

from guarded import ROUNDS, enough
from py_trees.behaviour import Behaviour
from py_trees.composites import Sequence
from steps import patient

from bt_controller.behaviours.robot_actions import GoTo


def mission(*, bug: bool = False) -> Behaviour:
    drives: list[Behaviour] = []
    for number, place in enumerate(ROUNDS):
        drive = GoTo(place, name=f"{number}: go to {place}")
        checked = number == 0 or not bug  # the bug: only the first drive is checked
        steps = [enough(str(number)), drive] if checked else [drive]
        drives.append(patient(Sequence(f"Round {number}", memory=True, children=steps)))
    return Sequence("Rounds", memory=True, children=drives)
