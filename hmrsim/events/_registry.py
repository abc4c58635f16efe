"""The registry of all events, ours and those of plug-ins, and the checks of their declarations."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from functools import cache
from typing import TYPE_CHECKING, Any, Self

from hmrsim.errors import PluginError
from hmrsim.events._event import Event, EventGroup, Part, Severity, description_of
from hmrsim.events._text import FORMATS, fields_in, plain, render
from hmrsim.plugins import discover

if TYPE_CHECKING:
    from hmrsim.events._event import Change
    from hmrsim.events._text import Format

_SUBJECTS = ("robot", "door", "lift", "dock", "entity", "participant")


class UnknownEvent(Event, severity=Severity.INFO, subject=_SUBJECTS):
    """An event of a newer version or of a plug-in that is not installed."""

    name: str
    values: Mapping[str, Any]

    @property
    def kind(self) -> str:  # type: ignore[override]  # per event, not per class
        """The kind of the event."""
        return self.name

    def as_dict(self) -> dict[str, Any]:
        """Return the fields as received."""
        return dict(self.values)

    @classmethod
    def from_json(cls, fields: Mapping[str, Any]) -> Self:
        """Return an event with any fields."""
        return cls(fields["kind"], {name: value for name, value in fields.items() if name not in ("kind", "stamp")})

    def text(self, _formats: Mapping[str, Format] | None = None) -> str:
        """Return the kind in words, and the fields that are not nested."""
        shown = (
            f"{name} {plain(value)}"
            for name, value in self.values.items()
            if name not in _SUBJECTS and isinstance(value, (str, int, float))
        )
        return ": ".join(filter(None, (self.name.replace("_", " "), ", ".join(shown))))


@cache
def groups() -> dict[str, EventGroup]:
    """Return the groups of events by name, including those of entry points ``hmrsim.events``."""
    return discover(sys.modules["hmrsim.events"], "EVENTS", EventGroup)


@cache
def registry() -> dict[str, type[Event]]:
    """Return all events by kind.

    Raises:
        PluginError: Two events have the same kind, or an event has no kind.
    """
    events: dict[str, type[Event]] = {}
    for group in groups().values():
        for event in group.events:
            if not event.kind or event.kind in events:
                raise PluginError(f"{event.__module__}: {event.__name__} needs a kind of its own, has {event.kind!r}")
            events[event.kind] = event
    return events


def from_json(fields: Mapping[str, Any]) -> Event:
    """Return the event of JSON from the wire, a trace or a recording.

    An unknown kind becomes an `UnknownEvent`.

    Raises:
        ValueError: The kind is missing, or the fields are not those of the kind.
    """
    kind = fields.get("kind")
    if not isinstance(kind, str):
        raise ValueError("kind is not text")  # noqa: TRY004 - an error of JSON, not of a program
    return registry().get(kind, UnknownEvent).from_json(fields)


def texts() -> dict[str, dict[str, Any]]:
    """Return the presentation and change of each kind of event, for the page."""
    return {
        event.kind: {"group": group.name, **event.presentation._asdict(), **_change_of(event)}
        for group in groups().values()
        for event in group.events
    }


def _change_of(event: type[Event]) -> dict[str, Any]:
    change = event.change
    return {} if change is None else {"changes": change.part, **({"sets": change.sets} if change.sets else {})}


_FORMATS = {*FORMATS, "goal"}
"""Formats that a template may name; callers provide the format of goals."""

_OURS = "hmrsim"
"""The prefix of hmrsim's own modules; plug-ins may register events in other ways."""


def flaws() -> Iterator[str]:
    """Yield the errors and omissions in the declarations of events, one line each, for `make lint`."""
    known = {*registry().values()}
    for event in _concrete(Event):
        if vars(event).get("kind") and event not in known:
            yield f"{event.__module__}: {event.__name__} is not in EVENTS"
    for event in registry().values():
        yield from (f"{event.__module__}: {event.__name__}: {flaw}" for flaw in _flaws_of(event))


def _concrete(event: type[Event]) -> Iterator[type[Event]]:
    for subclass in event.__subclasses__():
        if subclass is not UnknownEvent and subclass.__module__.startswith(_OURS):
            yield subclass
            yield from _concrete(subclass)


def _flaws_of(event: type[Event]) -> Iterator[str]:
    if not event.__doc__:
        yield "has no docstring"
    for field in event._fields:
        if not description_of(event, field):
            yield f"{field} has no description"
    names = {field.rstrip("_") for field in event._fields}
    severity, subject, text = event.presentation
    for name, form in [*fields_in(severity), *fields_in(text), *((name, "") for name in subject)]:
        if name not in names and not event.rest:
            yield f"is shown with {name!r}, which is not one of its fields"
        if form not in _FORMATS:
            yield f"is shown with a format {form!r}, which does not exist"
    if not text:
        yield "has no text"
    if "{" not in severity and render(severity, {}) not in [*Severity]:
        yield f"has the severity {severity!r}, which does not exist"
    if event.change is not None:
        yield from _flaws_of_change(event.change, names)


def _flaws_of_change(change: Change, names: set[str]) -> Iterator[str]:
    if change.part not in [*Part]:
        yield f"changes {change.part!r}, which is no part of a scene"
    yield from (f"sets {name!r}, which is a field of it" for name in sorted(names.intersection(change.sets)))
