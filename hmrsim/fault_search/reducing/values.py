"""Simpler values of a thing: a shorter time, the first moment, fewer goals."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from hmrsim.fault_search.schedules.thing import Thing

_SECONDS: Final = (1.0, 5.0, 10.0, 30.0, 60.0)
"""Durations that are easy to read."""


_EARLIER: Final = 10
"""Up to which of its kind an earlier event is tried, one after the other."""


def simpler(thing: Thing) -> Iterator[Thing]:
    """Yield the same thing with one simpler value, the simplest first."""
    when = dict(thing.anchor)
    for said in _anchors(when):
        yield thing.replaced(when=said)
    if thing.said.get("count", 1) > 1:
        yield thing.replaced(count=1)
    for name in ("duration", "restart_after"):
        seconds = thing.said.get(name)
        if isinstance(seconds, (int, float)):
            yield from (thing.replaced(**{name: each}) for each in _SECONDS if each < seconds)


def _anchors(when: dict[str, Any]) -> Iterator[dict[str, Any]]:
    after = when.get("after", 0.0)
    if after:
        yield {key: value for key, value in when.items() if key != "after"}
        for digits in (0, 1):
            rounded = round(after, digits)
            if rounded not in (0.0, after):
                yield {**when, "after": rounded}
    nth = when.get("nth", 1)
    if nth > 1:
        yield {key: value for key, value in when.items() if key != "nth"}
    # At an earlier one the thing may be enough alone.
    yield from ({**when, "nth": earlier} for earlier in range(2, min(nth, _EARLIER)))
