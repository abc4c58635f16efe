"""The services of the world, one module per subject.

A service is data: a name, its ROS type, and a function that serves it in the simulation's thread. Server, schema and
tests are generic over it.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache, cached_property
from typing import TYPE_CHECKING, Any, Final, Generic, TypeVar

from hmrsim.interfaces.message import Message
from hmrsim.interfaces.simulation_interfaces import Result
from hmrsim.plugins import discover

if TYPE_CHECKING:
    from hmrsim.simulation.simulator import Simulator

Q = TypeVar("Q", bound=Message)
A = TypeVar("A", bound=Message)


@dataclass(frozen=True)
class Service(Generic[Q, A]):
    """A service of the world.

    Attributes:
        name: The name in keys.
        request: The request's message type.
        response: The response's message type.
        serve: Answers a request. The answer depends on nothing but the world, its seed and the request, because a
            replay serves the request again. A service that takes simulated time returns a function instead, which
            is called with the callback for the answer.
        changes_world: Whether a replay has to repeat the call.
        recorded: Turns a request into one that needs nothing from outside the simulation, such as a file. The
            simulator serves and records the new request. It may return the answer instead, if the request is invalid.
        features: The features of the simulator that it provides, by the numbers of SimulatorFeatures.
        example: A valid request in the world of the contract tests, in plain values.
    """

    name: str
    request: type[Q]
    response: type[A]
    serve: Callable[[Simulator, Q], A | Callable[[Callable[[A], None]], None]]
    changes_world: bool = False
    recorded: Callable[[Simulator, Q], Q | A] = field(default=lambda _simulator, request: request)
    features: tuple[int, ...] = ()
    example: Mapping[str, Any] = field(default_factory=dict)

    @cached_property
    def ros_type(self) -> str:
        """The ROS name of the service, such as ``simulation_interfaces/srv/SpawnEntity``."""
        return self.request.ros_type.removesuffix("_Request")


AnyService = Service[Any, Any]

OK: Final = Result(result=Result.RESULT_OK)


class RequestFailed(ValueError):
    """A request that can't be served; *code* is the reason as a number of `Result` or of the service."""

    def __init__(self, message: str, code: int = Result.RESULT_OPERATION_FAILED) -> None:
        self.code = code
        super().__init__(message)


def failed(why: str, code: int = Result.RESULT_OPERATION_FAILED) -> Result:
    """Return the result of a request that failed, with the reason."""
    return Result(result=code, error_message=why)


@cache
def registry() -> dict[str, AnyService]:
    """Return all services by name."""
    return discover(sys.modules[__name__], "SERVICE", Service)
