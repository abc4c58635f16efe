"""The guard compares with the wrong sign, so it charges a full battery and ignores a low one."""

import operator

from guarded import LEAST, ROUNDS, enough
from py_trees.behaviour import Behaviour
from py_trees.composites import Sequence
from steps import patient

from bt_controller.behaviours.robot_actions import GoTo


def mission(*, bug: bool = False) -> Behaviour:
    compare = operator.le if bug else operator.ge  # the bug: the sign
    drives: list[Behaviour] = []
    for number, place in enumerate(ROUNDS):
        steps = [enough(str(number), LEAST, compare), GoTo(place, name=f"{number}: go to {place}")]
        drives.append(patient(Sequence(f"Round {number}", memory=True, children=steps)))
    return Sequence("Rounds", memory=True, children=drives)
