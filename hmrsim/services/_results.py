"""Results of requests, as simulation_interfaces defines them."""

from __future__ import annotations

from hmrsim.interfaces.simulation_interfaces import Result

OK = Result(result=Result.RESULT_OK)


class RequestFailed(ValueError):
    """A request can't be served; *code* says why, for programs."""

    def __init__(self, message: str, code: int = Result.RESULT_OPERATION_FAILED) -> None:
        self.code = code
        super().__init__(message)


def failed(why: str, code: int = Result.RESULT_OPERATION_FAILED) -> Result:
    """Return the result of a request that failed, with the reason."""
    return Result(result=code, error_message=why)


def of_steps(why_not: str) -> Result:
    """Return the result of a request for steps: success, unless there is a reason against it."""
    return failed(why_not) if why_not else OK
