"""The guard requires the charge of the next leg, and forgets the leg back to the charger."""

from guarded import LEAST, ROUNDS, enough
from py_trees.behaviour import Behaviour
from py_trees.composites import Sequence
from steps import patient

from bt_controller.behaviours.robot_actions import GoTo

LEG = 0.06
"""The share of a battery that the drive from one ward to the next takes, and a little more."""


def mission(*, bug: bool = False) -> Behaviour:
    least = LEG if bug else LEAST  # the bug: the way back does not count
    drives: list[Behaviour] = []
    for number, place in enumerate(ROUNDS):
        steps = [enough(str(number), least), GoTo(place, name=f"{number}: go to {place}")]
        drives.append(patient(Sequence(f"Round {number}", memory=True, children=steps)))
    return Sequence("Rounds", memory=True, children=drives)
