"""Goals of the robot are rejected although it could execute them, as by a robot that is busy with something else."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Annotated, Literal

from pydantic import Field

from hmrsim.faults import Case, FaultType, Name, Spell
from hmrsim.faults._counting import Countdown


class GoalsRejected(Spell):
    """Goals of a robot that are rejected.

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
    wanted = case.settings
    why = _WHY[wanted.reason].format(robot=wanted.robot)
    reject = partial(case.roster.goals.reject, wanted.robot, wanted.action, reason=wanted.reason, why=why)
    return Countdown(case, wanted.count, lambda done: reject(done=done)).end


FAULT = FaultType(
    name="goals_rejected", settings=GoalsRejected, begin=_begin, example={"robot": "wall_e"}, title="Goals rejected"
)
