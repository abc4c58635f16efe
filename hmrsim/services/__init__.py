"""The services of the world itself, one per file.

A service is data: a name, its ROS type, and a function that serves it in the simulation's thread. Server, schema and
tests are generic over it.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache, cached_property
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from hmrsim.interfaces.message import Message
from hmrsim.plugins import discover

if TYPE_CHECKING:
    from hmrsim.simulation.simulator import Simulator

Q = TypeVar("Q", bound=Message)
A = TypeVar("A", bound=Message)


@dataclass(frozen=True)
class Service(Generic[Q, A]):
    """A service of the world.

    Attributes:
        name: Its name in keys, and that of its module.
        request: The request's message type.
        response: The response's message type.
        serve: Answers a request, by the world, its seed and the request alone: it is served again in a replay. What
            takes simulated time returns a function in place of the answer; it is given whom to tell the answer.
        changes_world: Whether it does something that a replay has to do again.
        recorded: Turns a request into one that needs nothing from outside the simulation, such as a file; that one
            is served. It may answer at once instead, if the request is invalid.
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


@cache
def registry() -> dict[str, AnyService]:
    """Return all services by name."""
    return discover(sys.modules[__name__], "SERVICE", Service)
