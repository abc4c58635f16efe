"""Advance a paused simulation by a number of steps, with feedback after each."""

from __future__ import annotations

from collections.abc import Generator
from typing import TYPE_CHECKING, Any, Protocol

from hmrsim.actions import Action, Codes, Report
from hmrsim.actions._inputs import Input
from hmrsim.interfaces.simulation_interfaces import Result, SimulateSteps

if TYPE_CHECKING:
    from simpy import Event

_FAILED = Result.RESULT_OPERATION_FAILED


class StepControl(Protocol):
    """The functions of a run's control of time that steps need."""

    def open(self, steps: int) -> None:
        """Allow time to move by a number of steps."""

    def step_end(self, number: int) -> Event:
        """Return the event of the end of a step; *number* counts from 1."""

    def shut(self) -> None:
        """Stop time."""


def _process(
    gate: StepControl, goal: SimulateSteps.Goal, report: Report[SimulateSteps.Feedback]
) -> Generator[Any, Any, SimulateSteps.Result]:
    gate.open(goal.steps)
    try:
        for done in range(1, goal.steps + 1):
            yield gate.step_end(done)
            report.send(SimulateSteps.Feedback(completed_steps=done, remaining_steps=goal.steps - done))
    finally:
        gate.shut()
    return _result(Result.RESULT_OK, "")


def _result(code: int, message: str) -> SimulateSteps.Result:
    return SimulateSteps.Result(result=Result(result=code, error_message=message))


ACTION = Action(
    name="simulate_steps",
    goal=SimulateSteps.Goal,
    result=SimulateSteps.Result,
    feedback=SimulateSteps.Feedback,
    process=_process,
    failure=_result,
    codes=Codes(canceled=_FAILED, preempted=_FAILED, rejected=_FAILED, unknown=_FAILED),
    of_world=True,
    holds_base=False,
    not_ready=lambda gate: gate.why_no_steps(),
    inputs={"steps": Input("Steps", default=1, minimum=1)},
    example={"steps": 20},
)
