"""What a report is made of: things that happened, each at its time, from whatever they were read."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

from hmrsim.interfaces.builtin_interfaces import NANOSECONDS

if TYPE_CHECKING:
    from collections.abc import Mapping

LATEST = 2**62
"""Nanoseconds; no stamp is later."""


class Misfit(ValueError):
    """What is said to have happened is not said as this version says it."""


class Occurrence(NamedTuple):
    """Something happened, as `_world/events` tells it; besides there are three kinds that nobody is told.

    ``scene`` is all that can be seen (`hmrsim.simulation.snapshot`), ``battery`` what is in a robot's battery: `robot`,
    `percentage`, and `charge` in units of energy, if it is known; ``commanded`` says only when something came from
    outside, before which nothing else may have happened for long.

    Attributes:
        at: When, in nanoseconds of simulated time.
        kind: What.
        fields: To whom and how.
    """

    at: int
    kind: str
    fields: Mapping[str, Any]


def occurrence_of(event: Mapping[str, Any]) -> Occurrence:
    """Return what an event says that was read.

    Raises:
        Misfit: It has no kind, or no time.
    """
    return Occurrence(time_of(event.get("stamp")), text(event, "kind"), event)


def time_of(stamp: Any) -> int:
    """Return a ROS time as nanoseconds."""
    if not isinstance(stamp, dict):
        raise Misfit("no stamp")
    at = whole(stamp, "sec") * NANOSECONDS + whole(stamp, "nanosec")
    if not 0 <= at <= LATEST:
        raise Misfit("a stamp out of range")
    return at


def text(fields: Mapping[str, Any], key: str, default: str | None = None) -> str:
    """Return a field that has to be text."""
    value = fields.get(key, default)
    if not isinstance(value, str):
        raise Misfit(f"{key} is no text")
    return value


def texts(fields: Mapping[str, Any], key: str) -> tuple[str, ...]:
    """Return a field that has to be a list of text; left out it is empty."""
    value = fields.get(key, ())
    if not isinstance(value, (list, tuple)) or not all(isinstance(each, str) for each in value):
        raise Misfit(f"{key} is no list of text")
    return tuple(value)


def records(fields: Mapping[str, Any], key: str) -> list[dict[str, Any]]:
    """Return a field that has to be a list of objects; left out it is empty."""
    value = fields.get(key) or []
    if not isinstance(value, list) or not all(isinstance(each, dict) for each in value):
        raise Misfit(f"{key} is no list of objects")
    return value


def whole(fields: Mapping[str, Any], key: str) -> int:
    """Return a field that has to be a whole number."""
    value = fields.get(key)
    if not isinstance(value, int):
        raise Misfit(f"{key} is no whole number")
    return value


def number(fields: Mapping[str, Any], key: str) -> float:
    """Return a field that has to be a finite number."""
    return _finite(fields.get(key))


def point(fields: Mapping[str, Any], key: str) -> tuple[float, float]:
    """Return the first two numbers of a field, which are a point's, or a pose's."""
    value = fields.get(key)
    if not isinstance(value, (list, tuple)) or len(value) < 2:  # noqa: PLR2004 - x and y
        raise Misfit(f"{key} is no point")
    return _finite(value[0]), _finite(value[1])


def lane(fields: Mapping[str, Any]) -> tuple[str, str] | None:
    """Return the lane that is named, if any."""
    if fields.get("lane") is None:
        return None
    named = texts(fields, "lane")
    if len(named) != 2:  # noqa: PLR2004 - from and to
        raise Misfit("lane is no pair of names")
    return named[0], named[1]


def _finite(value: Any) -> float:
    if not isinstance(value, (int, float)) or not abs(value) < 1e300 or math.isnan(value):  # noqa: PLR2004
        raise Misfit("no finite number")
    return float(value)
