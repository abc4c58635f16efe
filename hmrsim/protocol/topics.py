"""The topics of robots and of the world, and conditions on their messages."""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping, Sequence
from enum import Enum
from types import MappingProxyType
from typing import Any, Final, NamedTuple

from hmrsim.interfaces.message import Message


class Topic(Enum):
    """The topics that a sink may want."""

    __hash__ = object.__hash__
    """Faster than Enum's, which is written in Python."""

    STATUS = "status"
    FEEDBACK = "feedback"
    ODOM = "odom"
    BATTERY_STATE = "battery_state"
    DETECTIONS = "detections"
    CLOCK = "clock"
    EVENTS = "events"
    MOTION = "motion"
    """The topic of the events that are not in traces (`hmrsim.events.Event.traced`)."""
    TIME = "time/state"
    """The state of time, and the participants that it waits for."""


ORDERS: Final[Mapping[str, Callable[[Any, Any], bool]]] = MappingProxyType(
    {"<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge}
)
"""The operators that order two numbers, or two texts."""

_NOTHING: Final = object()


class Comparison(NamedTuple):
    """A comparison of a message's field with a value; one with a field that is not there, or of another type, fails.

    Attributes:
        path: The names of the enclosing fields and of the field, from the outside; indices for items of lists.
        operator: ``==``, ``!=`` or one of `ORDERS`.
        value: A number, a text, true, false or null.
    """

    path: tuple[str, ...]
    operator: str
    value: float | str | bool | None

    def holds(self, message: object) -> bool:
        """Return whether it is true of a message."""
        found = _field(message, self.path)
        if found is _NOTHING:
            return False
        if order := ORDERS.get(self.operator):
            return _kind(found) is _kind(self.value) is not None and order(found, self.value)
        same = _kind(found) is _kind(self.value) and found == self.value
        return same is (self.operator == "==")


class Watch(NamedTuple):
    """The request to stop time when all comparisons hold in one message; answered by `Watching`.

    Attributes:
        name: The sender's name for it; a condition of the same name is replaced.
        robot: Of which robot; empty for the events of the world.
        action: Of which action, for `Topic.FEEDBACK`.
    """

    name: str
    topic: Topic
    robot: str = ""
    action: str = ""
    comparisons: tuple[Comparison, ...] = ()

    def holds(self, message: object) -> bool:
        """Return whether all comparisons are true of a message."""
        return all(each.holds(message) for each in self.comparisons)


class Unwatch(NamedTuple):
    """The request to stop watching a condition, if it is watched; answered by `Watching`."""

    name: str


class Watching(NamedTuple):
    """The answer to a request to watch a condition."""

    watching: bool


def _kind(value: object) -> type | None:
    """Return the operand to compare a value with; None if the value has no order."""
    if isinstance(value, bool) or value is None:
        return None
    return str if isinstance(value, str) else float if isinstance(value, (int, float)) else None


def _field(value: object, path: Sequence[str]) -> object:
    for part in path:
        match value:
            case Message() if part in type(value).model_fields:
                value = getattr(value, part)
            case Mapping() if part in value:
                value = value[part]
            case list() | tuple() if part.isdecimal() and int(part) < len(value):
                value = value[int(part)]
            case _:
                return _NOTHING
    return value
