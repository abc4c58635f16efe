"""The input of a history: timed occurrences, from any source."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from hmrsim.events import Event, from_json
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS

LATEST = 2**62
"""Nanoseconds; no stamp is later."""


class Misfit(ValueError):
    """An occurrence is not in the format of this version."""


class SceneSeen(NamedTuple):
    """The complete state at some time (`hmrsim.simulation.snapshot`)."""

    fields: Mapping[str, Any]


class BatterySeen(NamedTuple):
    """The charge of a robot's battery: a share, and units of energy if they are known."""

    robot: str
    percentage: float
    charge: float | None = None


class Commanded(NamedTuple):
    """An external command, which may follow a long time without events; with its line if one was read."""

    line: Mapping[str, Any] | None = None


class Malformed(NamedTuple):
    """An event that does not have the fields of its kind."""

    kind: str
    error: str


Happening = Event | SceneSeen | BatterySeen | Commanded | Malformed


class Occurrence(NamedTuple):
    """An event, or a sample, with its time.

    Attributes:
        at: In nanoseconds of simulated time.
    """

    at: int
    event: Happening

    @property
    def counted(self) -> str:
        """The kind under which a report counts it; empty if it is not counted."""
        match self.event:
            case Event() as event:
                return event.kind if event.traced else ""
            case Malformed(kind):
                return kind
            case Commanded(line) if line is not None:
                return COMMAND
        return ""


COMMAND = "command"
"""The kind of a trace's lines of external commands."""


def occurrence_of(event: Mapping[str, Any]) -> Occurrence:
    """Return the occurrence of an event in plain values.

    Raises:
        Misfit: It has no kind, or no time.
    """
    at, kind = time_of(event.get("stamp")), text(event, "kind")
    try:
        return Occurrence(at, Commanded(event) if kind == COMMAND else from_json(event))
    except ValueError as error:
        return Occurrence(at, Malformed(kind, str(error)))


def time_of(stamp: Any) -> int:
    """Return a ROS time as nanoseconds."""
    if not isinstance(stamp, dict):
        raise Misfit("no stamp")
    at = whole(stamp, "sec") * NANOSECONDS + whole(stamp, "nanosec")
    if not 0 <= at <= LATEST:
        raise Misfit("a stamp out of range")
    return at


def text(fields: Mapping[str, Any], key: str, default: str | None = None) -> str:
    """Return a field that must be text."""
    value = fields.get(key, default)
    if not isinstance(value, str):
        raise Misfit(f"{key} is not text")
    return value


def texts(fields: Mapping[str, Any], key: str) -> tuple[str, ...]:
    """Return a field that must be a list of text; empty if it is missing."""
    value = fields.get(key, ())
    if not isinstance(value, (list, tuple)) or not all(isinstance(each, str) for each in value):
        raise Misfit(f"{key} is not a list of text")
    return tuple(value)


def records(fields: Mapping[str, Any], key: str) -> list[dict[str, Any]]:
    """Return a field that must be a list of objects; empty if it is missing."""
    value = fields.get(key) or []
    if not isinstance(value, list) or not all(isinstance(each, dict) for each in value):
        raise Misfit(f"{key} is not a list of objects")
    return value


def whole(fields: Mapping[str, Any], key: str) -> int:
    """Return a field that must be a whole number."""
    value = fields.get(key)
    if not isinstance(value, int):
        raise Misfit(f"{key} is not a whole number")
    return value


def number(fields: Mapping[str, Any], key: str) -> float:
    """Return a field that must be a finite number."""
    return _finite(fields.get(key))


def point(fields: Mapping[str, Any], key: str) -> tuple[float, float]:
    """Return the first two numbers of a field, which are a point's, or a pose's."""
    value = fields.get(key)
    if not isinstance(value, (list, tuple)) or len(value) < 2:  # noqa: PLR2004 - x and y
        raise Misfit(f"{key} is not a point")
    return _finite(value[0]), _finite(value[1])


def lane(fields: Mapping[str, Any]) -> tuple[str, str] | None:
    """Return the lane in a field, if any."""
    if fields.get("lane") is None:
        return None
    named = texts(fields, "lane")
    if len(named) != 2:  # noqa: PLR2004 - from and to
        raise Misfit("lane is not a pair of names")
    return named[0], named[1]


def _finite(value: Any) -> float:
    if not isinstance(value, (int, float)) or not abs(value) < 1e300 or math.isnan(value):  # noqa: PLR2004
        raise Misfit("no finite number")
    return float(value)
