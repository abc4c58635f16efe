"""Types of messages, services and actions in a distribution of ROS 2: names, hashes and codecs.

All types derive from our models. A hash or a codec is built when it is first used.
Distributions with the same type share one object.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cache, cached_property
from typing import TYPE_CHECKING, Any

from hmrsim.interfaces.action_msgs import CancelGoal, GoalStatusArray
from hmrsim_zenoh.ros2.codec import derived
from hmrsim_zenoh.ros2.codec.cdr import decoder, encoder
from hmrsim_zenoh.ros2.codec.distros import OURS, structure_in
from hmrsim_zenoh.ros2.codec.rihs01 import Structure, structure

if TYPE_CHECKING:
    from hmrsim.actions import AnyAction
    from hmrsim.interfaces.message import Message


@dataclass(frozen=True, eq=False)
class _Type:
    structure: Structure

    @property
    def name(self) -> str:
        """The name, such as ``nav2_msgs/action/NavigateToPose_FeedbackMessage``."""
        return self.structure.name

    @cached_property
    def dds_name(self) -> str:
        """The name in keys, such as ``nav2_msgs::action::dds_::NavigateToPose_FeedbackMessage_``."""
        return dds_name(self.name)

    @cached_property
    def hash(self) -> str:
        """``RIHS01_`` and the hash in hex; a service has one hash for request and response."""
        return self.structure.hash()


class MessageType(_Type):
    """A message type in one distribution."""

    @cached_property
    def encode(self) -> Callable[[Message | Mapping[str, Any]], bytes]:
        """The function that encodes a message or its plain values; it raises `CdrError`."""
        return encoder(self.structure)

    @cached_property
    def decode(self) -> Callable[[bytes], dict[str, Any]]:
        """The function that decodes bytes to plain values, for a model to validate; it raises `CdrError`."""
        return decoder(self.structure)


@dataclass(frozen=True, eq=False)
class ServiceType(_Type):
    """A service type in one distribution."""

    request: MessageType
    response: MessageType


@dataclass(frozen=True)
class ActionType:
    """An action type in one distribution."""

    name: str
    send_goal: ServiceType
    cancel_goal: ServiceType
    get_result: ServiceType
    feedback: MessageType
    status: MessageType


def message_type(cls: type[Message], distro: str = OURS) -> MessageType:
    """Return the type of a message.

    Raises:
        ValueError: No such distribution is known.
    """
    return _message(structure_in(distro, structure(cls)))


def service_type(name: str, request: type[Message], response: type[Message], distro: str = OURS) -> ServiceType:
    """Return the type of a service, such as ``simulation_interfaces/srv/SpawnEntity``.

    Raises:
        ValueError: No such distribution is known.
    """
    return _service(distro, name, structure(request), structure(response))


def action_type(
    name: str, goal: type[Message], result: type[Message], feedback: type[Message], distro: str = OURS
) -> ActionType:
    """Return the type of an action, such as ``nav2_msgs/action/NavigateToPose``.

    Raises:
        ValueError: No such distribution is known.
    """
    return _action(
        name,
        _service(distro, f"{name}_SendGoal", *derived.send_goal(name, structure(goal))),
        service_type("action_msgs/srv/CancelGoal", CancelGoal.Request, CancelGoal.Response, distro),
        _service(distro, f"{name}_GetResult", *derived.get_result(name, structure(result))),
        _message(structure_in(distro, derived.feedback_message(name, structure(feedback)))),
        message_type(GoalStatusArray, distro),
    )


def action_types(action: AnyAction, distros: Iterable[str]) -> tuple[ActionType, ...]:
    """Return the types of an action in some distributions.

    Raises:
        ValueError: No such distribution is known.
    """
    kinds = (action.ros_type, action.goal, action.result, action.feedback)
    return tuple(action_type(*kinds, distro) for distro in distros)


def dds_name(name: str) -> str:
    """Return a type's name in keys."""
    package, kind, short = name.split("/")
    return f"{package}::{kind}::dds_::{short}_"


def _service(distro: str, name: str, request: Structure, response: Structure) -> ServiceType:
    whole, *parts = (structure_in(distro, one) for one in (derived.service(name, request, response), request, response))
    return _one_service(whole, *map(_message, parts))


# Equal definitions share one type, for all callers and distributions.
_message = cache(MessageType)
_one_service = cache(ServiceType)
_action = cache(ActionType)
