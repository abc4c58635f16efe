"""The services of the world, one module per subject.

A service is data: its ROS type and a function that serves it in the simulation's thread. Server, schema and
tests are generic over it.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache, cached_property
from typing import TYPE_CHECKING, Any, Final

from hmrsim.interfaces.message import Message
from hmrsim.interfaces.simulation_interfaces import Result
from hmrsim.plugins import discover

if TYPE_CHECKING:
    from hmrsim.simulation.simulator import Simulator

OK: Final = Result(result=Result.RESULT_OK)


def failed(why: str, code: int = Result.RESULT_OPERATION_FAILED) -> Result:
    """Return the result of a request that failed, with the reason."""
    return Result(result=code, error_message=why)


class RequestFailed(ValueError):
    """A request that can't be served; *code* is the reason as a number of `Result` or of the service."""

    def __init__(self, message: str, code: int = Result.RESULT_OPERATION_FAILED) -> None:
        self.result = failed(message, code)
        super().__init__(message)


Answer = Callable[[Message], None]
"""Sends the response of a service that takes simulated time."""


@dataclass(frozen=True)
class Service:
    """A service of the world.

    Attributes:
        ros: The ROS service: a class named as the service is, with the message types `Request` and `Response`.
        respond: Serves a request and returns the response, or None for one that only says that all went well. It
            depends on nothing but the world, its seed and the request, because a replay serves the request again. A
            service that takes simulated time returns a function instead, which is called with the callback for the
            response. A request that fails raises `RequestFailed`. The response of a service that returns None or raises
            this error has to have a field ``result`` of type `Result`.
        changes_world: Whether a replay has to repeat the call.
        resolve: Turns a request into one that needs nothing from outside the simulation, such as a file. The
            simulator serves and records the new request. An invalid request raises `RequestFailed`.
        features: The features of the simulator that it provides, by the numbers of SimulatorFeatures.
        example: A valid request in the world of the contract tests, in plain values.
    """

    ros: Any
    respond: Callable[[Simulator, Any], Message | Callable[[Answer], None] | None]
    changes_world: bool = False
    resolve: Callable[[Simulator, Any], Message] = field(default=lambda _simulator, request: request)
    features: tuple[int, ...] = ()
    example: Mapping[str, Any] = field(default_factory=dict)

    @cached_property
    def name(self) -> str:
        """The name in keys, such as ``spawn_entity``."""
        return re.sub(r"(?<!^)(?=[A-Z])", "_", self.ros.__name__).lower()

    @cached_property
    def ros_type(self) -> str:
        """The ROS name of the service, such as ``simulation_interfaces/srv/SpawnEntity``."""
        return self.request.ros_type.removesuffix("_Request")

    @property
    def request(self) -> type[Message]:
        """The request's message type."""
        request: type[Message] = self.ros.Request
        return request

    @property
    def response(self) -> type[Message]:
        """The response's message type."""
        response: type[Message] = self.ros.Response
        return response

    def serve(self, simulator: Simulator, request: Message) -> Message | Callable[[Answer], None]:
        """Return the response to a request, or a function to call with the callback for it."""
        try:
            return self.respond(simulator, request) or self._outcome(OK)
        except RequestFailed as error:
            return self._outcome(error.result)

    def recorded(self, simulator: Simulator, request: Message) -> Message:
        """Return the request to serve and to record, or the response if the request is invalid."""
        try:
            return self.resolve(simulator, request)
        except RequestFailed as error:
            return self._outcome(error.result)

    def _outcome(self, result: Result) -> Message:
        response: Message = self.ros.Response(result=result)
        return response


@cache
def registry() -> dict[str, Service]:
    """Return all services by name."""
    return discover(sys.modules[__name__], "SERVICE", Service)
