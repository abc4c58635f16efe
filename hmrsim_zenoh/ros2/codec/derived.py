"""The types that ROS derives from actions and services, without interface files."""

from __future__ import annotations

from functools import cache

from hmrsim.interfaces.builtin_interfaces import Time
from hmrsim.interfaces.service_msgs import ServiceEventInfo
from hmrsim.interfaces.unique_identifier_msgs import UUID
from hmrsim_zenoh.ros2.codec.rihs01 import Field, Kind, Structure, structure


@cache
def service(name: str, request: Structure, response: Structure) -> Structure:
    """Return the type of a service, which is never serialised and only determines the service's hash."""
    event = Structure(
        f"{name}_Event",
        (
            _nested("info", structure(ServiceEventInfo)),
            Field("request", kind=Kind.BOUNDED, capacity=1, nested=request, path=("request",)),
            Field("response", kind=Kind.BOUNDED, capacity=1, nested=response, path=("response",)),
        ),
    )
    return Structure(
        name,
        (_nested("request_message", request), _nested("response_message", response), _nested("event_message", event)),
    )


@cache
def send_goal(action: str, goal: Structure) -> tuple[Structure, Structure]:
    """Return request and response of an action's send_goal service."""
    request = Structure(f"{action}_SendGoal_Request", (_goal_id(), _nested("goal", goal)))
    accepted = Field("accepted", "boolean", path=("accepted",))
    return request, Structure(f"{action}_SendGoal_Response", (accepted, _nested("stamp", structure(Time))))


@cache
def get_result(action: str, result: Structure) -> tuple[Structure, Structure]:
    """Return request and response of an action's get_result service."""
    request = Structure(f"{action}_GetResult_Request", (_goal_id(),))
    status = Field("status", "int8", path=("status",))
    return request, Structure(f"{action}_GetResult_Response", (status, _nested("result", result)))


@cache
def feedback_message(action: str, feedback: Structure) -> Structure:
    """Return the message of an action's feedback topic."""
    return Structure(f"{action}_FeedbackMessage", (_goal_id(), _nested("feedback", feedback)))


def _goal_id() -> Field:
    return _nested("goal_id", structure(UUID))


def _nested(name: str, held: Structure) -> Field:
    return Field(name, nested=held, path=(name,))
