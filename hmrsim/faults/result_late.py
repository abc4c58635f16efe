"""The status and results of the robot's goals reach clients late."""

from __future__ import annotations

from collections.abc import Callable

from hmrsim.faults import Case, FaultType, Name, SomeSeconds, Spell


class ResultLate(Spell):
    """Late updates about a robot's goals.

    Attributes:
        robot: The robot's name.
        delay: Seconds by which updates are late.
    """

    robot: Name
    delay: SomeSeconds


def _begin(case: Case[ResultLate]) -> Callable[[], None]:
    return case.roster.delay_news(case.settings.robot, case.settings.delay)


FAULT = FaultType(
    name="result_late",
    settings=ResultLate,
    begin=_begin,
    example={"robot": "wall_e", "delay": 2.0},
    title="Results late",
)
