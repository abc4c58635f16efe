"""The first difference between two runs."""

from __future__ import annotations

import json
from itertools import zip_longest
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from hmrsim.interfaces.builtin_interfaces import NANOSECONDS

if TYPE_CHECKING:
    from collections.abc import Iterable

_MAX_LINE: Final = 300
_ALWAYS: Final = frozenset({"kind", "robot", "stamp"})


class Difference(NamedTuple):
    """The first line in which two traces differ.

    Attributes:
        line: Its number, from 1.
        was: The line of the first trace; None if that ends before.
        now: The line of the second trace, in the same form.
        before: The last lines that both have in common, if they were kept.
        after: The next lines of the first trace, if they were kept.
    """

    line: int
    was: str | None
    now: str | None
    before: tuple[str, ...] = ()
    after: tuple[str, ...] = ()

    def describe(self) -> str:
        """Return when and where it is, what was there, and what is there now."""
        there = _values(self.now) or _values(self.was)
        at = f"at {_seconds(there):.3f} s" if "stamp" in there else "at the start"
        robot = f", robot {there['robot']}" if "robot" in there else ""
        return f"first difference: line {self.line}, {at}{robot}\n  was {_shown(self.was)}\n  is  {_shown(self.now)}"


def compared(was: Iterable[str], now: Iterable[str]) -> tuple[int, Difference | None]:
    """Return how many lines two traces have in common from their start, and where they first differ, if they do."""
    same = 0
    for one, other in zip_longest(was, now):
        if one != other:
            return same, Difference(same + 1, one, other)
        same += 1
    return same, None


def first_difference(was: str, now: str) -> Difference | None:
    """Return where two traces first differ; None if they don't."""
    return compared(was.splitlines(), now.splitlines())[1]


def _seconds(values: dict[str, Any]) -> float:
    stamp = values["stamp"]
    return float(stamp.get("sec", 0) + stamp.get("nanosec", 0) / NANOSECONDS)


def _values(line: str | None) -> dict[str, Any]:
    try:
        values = json.loads(line or "{}")
    except ValueError:
        return {}
    return values if isinstance(values, dict) else {}


def _shown(line: str | None) -> str:
    """Return the event of a line with its robot, time and fields."""
    if line is None:
        return "nothing: it ends before"
    values = _values(line)
    if not values:
        return line[:_MAX_LINE]
    at = f"{_seconds(values):.9f} s" if "stamp" in values else ""
    fields = [f"{key}={json.dumps(value, sort_keys=True)}" for key, value in values.items() if key not in _ALWAYS]
    text = " ".join(filter(None, [at, str(values.get("robot", "")), str(values.get("kind", "")), *fields]))
    return text if len(text) <= _MAX_LINE else f"{text[:_MAX_LINE]}..."
