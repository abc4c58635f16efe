"""Goals of the robot end ABORTED although it could execute them: docking fails, no path is found, the arm gives up."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Annotated

from pydantic import Field

from hmrsim.faults import Case, FaultType, Name, Seconds, Spell
from hmrsim.faults._counting import Countdown


class GoalsAborted(Spell):
    """Goals of a robot that end as aborted.

    Attributes:
        robot: The robot's name.
        action: The action of the goals, such as ``dock_robot``; None for all.
        error_code: The code in the result, one of the action's; None for its code for unknown errors.
        error_msg: The text in the result; empty for the name of the fault.
        delay: Seconds of execution before a goal is aborted; goals that have executed for longer end immediately.
        count: The number of goals to abort before the fault ends; None for all goals during the fault.
    """

    robot: Name
    action: Name | None = None
    error_code: Annotated[int, Field(strict=True)] | None = None
    error_msg: Annotated[str, Field(max_length=1000)] = ""
    delay: Seconds = 0.0
    count: Annotated[int, Field(strict=True, ge=1)] | None = 1


def _begin(case: Case[GoalsAborted]) -> Callable[[], None]:
    wanted = case.settings
    abort = partial(
        case.roster.goals.abort,
        wanted.robot,
        wanted.action,
        code=wanted.error_code,
        why=wanted.error_msg or f"fault {case.name}",
        cause=FAULT.name,
        delay=wanted.delay,
    )
    return Countdown(case, wanted.count, lambda done: abort(done=done)).end


FAULT = FaultType(
    name="goals_aborted", settings=GoalsAborted, begin=_begin, example={"robot": "wall_e"}, title="Goals aborted"
)
