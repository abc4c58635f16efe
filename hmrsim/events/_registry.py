"""All kinds of events: ours, those of plug-ins, and those that are not known here."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from functools import cache
from typing import TYPE_CHECKING, Any, Self

from hmrsim.errors import PluginError
from hmrsim.events._event import Event, EventGroup, Severity
from hmrsim.events._text import plain
from hmrsim.plugins import discover

if TYPE_CHECKING:
    from hmrsim.events._text import Format

_SUBJECTS = ("robot", "door", "lift", "dock", "entity", "participant")


class UnknownEvent(Event, severity=Severity.INFO, subject=_SUBJECTS):
    """An event of a newer version, or of a plug-in that is not installed here: its kind and its fields."""

    name: str
    values: Mapping[str, Any]

    @property
    def kind(self) -> str:  # type: ignore[override]  # of each, not of the class
        """The event's kind."""
        return self.name

    def as_dict(self) -> dict[str, Any]:
        """Return its fields as they came."""
        return dict(self.values)

    @classmethod
    def from_json(cls, fields: Mapping[str, Any]) -> Self:
        """Return the event of any plain values."""
        return cls(fields["kind"], {name: value for name, value in fields.items() if name not in ("kind", "stamp")})

    def text(self, _formats: Mapping[str, Format] | None = None) -> str:
        """Return its kind in words, and its fields but for nested ones."""
        shown = (
            f"{name} {plain(value)}"
            for name, value in self.values.items()
            if name not in _SUBJECTS and isinstance(value, (str, int, float))
        )
        return ": ".join(filter(None, (self.name.replace("_", " "), ", ".join(shown))))


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
