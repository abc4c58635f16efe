"""All ROS types that hmrsim supports, for tests that cover each of them."""

from __future__ import annotations

import importlib
import pkgutil
from functools import cache
from types import SimpleNamespace
from typing import TYPE_CHECKING

import hmrsim.interfaces
from hmrsim.interfaces.message import Message
from hmrsim_zenoh.ros2.codec.types import action_type, message_type, service_type

if TYPE_CHECKING:
    from collections.abc import Iterator

    from hmrsim_zenoh.ros2.codec.structures import Structure


@cache
def messages() -> dict[str, type[Message]]:
    """Return all messages in hmrsim.interfaces, by ROS type and in the order of these."""
    for module in pkgutil.iter_modules(hmrsim.interfaces.__path__, "hmrsim.interfaces."):
        importlib.import_module(module.name)
    found = [cls for cls in Message.__subclasses__() if cls.__module__.startswith("hmrsim.interfaces.")]
    return {cls.ros_type: cls for cls in sorted(found, key=lambda cls: cls.ros_type)}


@cache
def structures(distro: str) -> dict[str, Structure]:
    """Return all types of a distribution by name, with nested types and those that ROS derives."""
    found: dict[str, Structure] = {}
    for described in _outermost(distro):
        _collect(described, found)
    return dict(sorted(found.items()))


def _outermost(distro: str) -> Iterator[Structure]:
    classes = messages()
    for name, cls in classes.items():
        yield message_type(cls, distro).structure
        whole, _, part = name.rpartition("_")
        if part == "Request":
            yield service_type(SimpleNamespace(Request=cls, Response=classes[f"{whole}_Response"]), distro).structure
        if part == "Goal":
            parts = {"result": classes[f"{whole}_Result"], "feedback": classes[f"{whole}_Feedback"]}
            action = action_type(SimpleNamespace(ros_type=whole, goal=cls, **parts), distro)
            services = (action.send_goal, action.cancel_goal, action.get_result)
            yield from (service.structure for service in services)
            yield action.feedback.structure


def _collect(described: Structure, found: dict[str, Structure]) -> None:
    found[described.name] = described
    for field in described.fields:
        if field.nested is not None and field.nested.name not in found:
            _collect(field.nested, found)
