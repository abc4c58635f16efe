"""The gripper misses the item that it reaches for, so that picking up fails."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from hmrsim.faults import Case, FaultType, Name, Probability, Spell


class ClawMisses(Spell):
    """Failures of a claw to grasp items.

    Attributes:
        robot: The robot's name.
        probability: The probability of a miss, for each attempt.
    """

    robot: Name
    probability: Probability = 1.0


def _begin(case: Case[ClawMisses]) -> Callable[[], None]:
    claw = case.claw
    misses = partial(case.happens, case.settings.probability)
    claw.misses.append(misses)
    return partial(claw.misses.remove, misses)


FAULT = FaultType(
    name="claw_misses",
    settings=ClawMisses,
    begin=_begin,
    component="claw",
    example={"robot": "wall_e"},
    title="Gripper misses",
)
