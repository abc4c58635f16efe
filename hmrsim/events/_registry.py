"""All kinds of events: ours, and those of plug-ins."""

from __future__ import annotations

import sys
from functools import cache
from typing import TYPE_CHECKING, Any

from hmrsim.errors import PluginError
from hmrsim.events._event import Event, EventGroup
from hmrsim.events._unknown import UnknownEvent
from hmrsim.plugins import discover

if TYPE_CHECKING:
    from collections.abc import Mapping


@cache
def groups() -> dict[str, EventGroup]:
    """Return the events of each subject, by its name; plug-ins add theirs by entry points ``hmrsim.events``."""
    return discover(sys.modules["hmrsim.events"], "EVENTS", EventGroup)


@cache
def registry() -> dict[str, type[Event]]:
    """Return all events by kind.

    Raises:
        PluginError: Two have one kind, or one has none.
    """
    found: dict[str, type[Event]] = {}
    for group in groups().values():
        for event in group.events:
            if not event.kind or event.kind in found:
                raise PluginError(f"{event.__module__}: {event.__name__} needs a kind of its own, has {event.kind!r}")
            found[event.kind] = event
    return found


def from_json(fields: Mapping[str, Any]) -> Event:
    """Return the event of its JSON, as it is on the wire, in traces and in recordings.

    An unknown kind becomes an `UnknownEvent`.

    Raises:
        ValueError: It has no kind, or its fields are not those of its kind.
    """
    kind = fields.get("kind")
    if not isinstance(kind, str):
        raise ValueError("kind is not text")  # noqa: TRY004 - of JSON, not of a program
    return registry().get(kind, UnknownEvent).from_json(fields)


def texts() -> dict[str, dict[str, Any]]:
    """Return how events are shown and what they change, by kind, as the page is given it."""
    return {
        event.kind: {"group": group.name, **event.presentation._asdict(), **_change_of(event)}
        for group in groups().values()
        for event in group.events
    }


def _change_of(event: type[Event]) -> dict[str, Any]:
    change = event.change
    return {} if change is None else {"changes": change.part, **({"sets": change.sets} if change.sets else {})}
