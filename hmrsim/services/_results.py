"""Results of requests, as simulation_interfaces defines them."""

from __future__ import annotations

from hmrsim.interfaces.simulation_interfaces import Result

OK = Result(result=Result.RESULT_OK)


def failed(why: str, code: int = Result.RESULT_OPERATION_FAILED) -> Result:
    """Return that it came to nothing, and why."""
    return Result(result=code, error_message=why)


def of_steps(why_not: str) -> Result:
    """Return what came of steps that were to be made: all of them, unless there is a reason why not."""
    return failed(why_not) if why_not else OK
