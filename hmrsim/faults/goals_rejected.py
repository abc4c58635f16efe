"""A fault: a robot rejects goals that it could execute, as if it were busy or not ready."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Annotated, Literal

from pydantic import Field

from hmrsim.faults import Case, FaultType, Name, Spell
from hmrsim.faults._counting import Countdown


class GoalsRejected(Spell):
    """The rejection of goals that a robot could execute.

    Attributes:
        robot: The robot's name.
        action: The action of the goals, such as ``navigate_to_pose``; None for all.
        reason: The reason in the answer.
        count: The number of goals to reject before the fault ends; None for all goals during the fault.
    """

    robot: Name
    action: Name | None = None
    reason: Literal["busy", "not_ready"] = "busy"
    count: Annotated[int, Field(strict=True, ge=1)] | None = None


_WHY = {"busy": "{robot} is busy with something else", "not_ready": "{robot} is not ready"}


def _begin(case: Case[GoalsRejected]) -> Callable[[], None]:
    settings = case.settings
    why = _WHY[settings.reason].format(robot=settings.robot)
    reject = partial(case.roster.goals.reject, settings.robot, settings.action, reason=settings.reason, why=why)
    return Countdown(case, settings.count, lambda done: reject(done=done)).end


FAULT = FaultType(
    name="goals_rejected", settings=GoalsRejected, begin=_begin, example={"robot": "wall_e"}, title="Goals rejected"
)
