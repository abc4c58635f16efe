"""Goals and results in a few words, whatever their action."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from hmrsim.interfaces.builtin_interfaces import Duration, Time
from hmrsim.interfaces.geometry_msgs import Pose, PoseStamped
from hmrsim.interfaces.message import Message

_MAX_PARTS: Final = 3


def summary(goal: Message) -> str:
    """Return a summary of a goal: points, names, durations, and numbers other than their default."""
    words = list(_words(goal))
    rest = [f"and {len(words) - _MAX_PARTS} more"] if len(words) > _MAX_PARTS else []
    return ", ".join([*words[:_MAX_PARTS], *rest])


def _words(value: object) -> Iterator[str]:
    if isinstance(value, PoseStamped):
        yield from _words(value.pose)
    elif isinstance(value, Pose):
        yield f"({value.position.x:g}, {value.position.y:g})"
    elif isinstance(value, Duration):
        yield f"{value.to_seconds():g} s"
    elif isinstance(value, list):
        for item in value:
            yield from _words(item)
    elif isinstance(value, Message) and not isinstance(value, Time):
        told = False
        for name, field in type(value).model_fields.items():
            part = getattr(value, name)
            # Clients send every field, so most have ROS's defaults, which the user has not set. The origin is a pose
            # to drive to as any other, but not beside the name of a dock.
            default = part == field.get_default(call_default_factory=True)
            if not default or (not told and isinstance(part, (Pose, PoseStamped))):
                told = True
                yield from _words(part)
    elif isinstance(value, (str, int, float)) and value:
        yield str(value) if isinstance(value, str) else f"{value:g}"
