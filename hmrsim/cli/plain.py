"""Messages in short form, without fields that have ROS's defaults."""

from __future__ import annotations

from typing import Any, Final

from hmrsim.interfaces.builtin_interfaces import Duration, Time
from hmrsim.interfaces.geometry_msgs import Point, Pose
from hmrsim.interfaces.message import Message

_VALUES: Final = (Duration, Time, Point, Pose)
"""Messages that are meaningful when all their fields are zero."""


def plain(message: Message) -> dict[str, Any]:
    """Return a message's plain values without the parts that have default values.

    Numbers are always included, as 0 may be of interest; so is *error_code*.
    """
    shown = {name: getattr(message, name) for name in type(message).model_fields}
    return {name: _value(value) for name, value in shown.items() if name == "error_code" or _says_something(value)}


def _says_something(value: object) -> bool:
    if isinstance(value, Message):
        return isinstance(value, _VALUES) or value != type(value)()
    return not isinstance(value, (str, list)) or bool(value)


def _value(value: object) -> object:
    if isinstance(value, Message):
        return plain(value)
    if isinstance(value, list):
        return [_value(part) for part in value]
    return value
