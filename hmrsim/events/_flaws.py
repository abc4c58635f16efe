"""Omissions in the declarations of events, for which `make lint` fails."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from hmrsim.events._event import Event, Severity, description_of
from hmrsim.events._parts import Part
from hmrsim.events._registry import UnknownEvent, registry
from hmrsim.events._text import FORMATS, fields_in, render

if TYPE_CHECKING:
    from hmrsim.events._parts import Change

_FORMATS = {*FORMATS, "goal"}
"""Formats that a template may name; that of a goal is the caller's."""

_OURS = "hmrsim"
"""The prefix of hmrsim's own modules; plug-ins may load theirs in other ways."""


def flaws() -> Iterator[str]:
    """Yield the omissions and errors in the declarations of events, one line each."""
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
        yield f"changes {change.part!r}, which is no part of a picture"
    yield from (f"sets {name!r}, which is a field of it" for name in sorted(names.intersection(change.sets)))
