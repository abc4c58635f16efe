"""The gripper drops the item that it holds, which blocks the lane where it falls."""

from __future__ import annotations

from collections.abc import Callable

from hmrsim.faults import Case, FaultType, Name, Occurrence, Probability


class ClawDrops(Occurrence):
    """The drop of the item that a claw holds.

    Attributes:
        robot: The robot's name.
        probability: The probability that the item drops.
    """

    robot: Name
    probability: Probability = 1.0


def _begin(case: Case[ClawDrops]) -> Callable[[], None]:
    if case.happens(case.settings.probability) and case.claw.item is not None:
        case.robot.drop(case.claw.item)
    return lambda: None


FAULT = FaultType(
    name="claw_drops",
    settings=ClawDrops,
    begin=_begin,
    component="claw",
    example={"robot": "wall_e"},
    title="Gripper drops its item",
)
