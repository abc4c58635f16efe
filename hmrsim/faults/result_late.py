"""What becomes of the robot's goals reaches clients late: their status, and their results."""

from __future__ import annotations

from collections.abc import Callable

from hmrsim.faults import Case, FaultType, Name, SomeSeconds, Spell


class ResultLate(Spell):
    """When which robot's news are late.

    Attributes:
        robot: Its name.
        delay: By how many seconds.
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
