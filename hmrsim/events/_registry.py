"""The registry of all events, ours and those of plug-ins, the checks of their declarations, and patterns of events.

Faults begin at events that match a pattern, and properties of runs refer to them.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from functools import cache
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from hmrsim.diagnostics import Finding, instead
from hmrsim.errors import PluginError
from hmrsim.events._event import Event, EventGroup, Part, Severity, description_of
from hmrsim.events._text import FORMATS, fields_in, plain, render
from hmrsim.events.goals import GoalStatusChanged, SendGoalRejected
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


GoalChange = Literal["accepted", "executing", "canceling", "succeeded", "canceled", "aborted", "ended", "rejected"]

STATUSES: Final[Mapping[str, frozenset[int]]] = MappingProxyType(
    {
        "accepted": frozenset({1}),
        "executing": frozenset({2}),
        "canceling": frozenset({3}),
        "succeeded": frozenset({4}),
        "canceled": frozenset({5}),
        "aborted": frozenset({6}),
        "ended": frozenset({4, 5, 6}),
        "rejected": frozenset(),
    }
)
"""The numbers of action_msgs/msg/GoalStatus for each change of a goal; a rejected goal has no status."""

_STATUS: Final = GoalStatusChanged.kind
_REJECTED: Final = SendGoalRejected.kind


class EventPattern(BaseModel):
    """A pattern of events: either an *event* or a *goal*.

    Attributes:
        event: A kind of event, such as ``picked``.
        where: Values of its fields, as in its JSON; all must be equal.
        goal: A change of a goal: a status in lower case, ``ended`` for any terminal status, or ``rejected``.
        action: The action of that goal, or None for any.
        robot: The robot of the event or goal, or None for any.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    event: str | None = Field(default=None, description="A kind of event, such as `picked`.")
    where: dict[str, Any] = Field(default={}, description="Values of the event's fields; all must be equal.")
    goal: GoalChange | None = Field(
        default=None, description="A change of a goal; `ended` stands for succeeded, canceled and aborted."
    )
    action: str | None = Field(default=None, description="The goal's action; omitted for any.")
    robot: str | None = Field(default=None, description="The robot of the event or goal; omitted for any.")

    @model_validator(mode="after")
    def _one(self) -> Self:
        if (self.event is None) is (self.goal is None):
            raise ValueError("expected either event: KIND or goal: STATUS")
        if self.goal is None and self.action is not None:
            raise ValueError("action belongs to goal; for an event say where: {action: …}")
        if self.goal is not None and self.where:
            raise ValueError("where belongs to event; for a goal say robot and action")
        return self

    @property
    def kind(self) -> str:
        """The kind of event that can match."""
        if self.goal is None:
            return self.event or ""
        return _REJECTED if self.goal == _REJECTED else _STATUS

    def matches(self, event: Event) -> bool:
        """Return whether an event matches."""
        kind = event.kind
        if self.goal is None:
            return kind == self.event and self._fits(event)
        if kind == _STATUS:
            return self.matches_goal(event.robot, event.action, event.status)  # type: ignore[attr-defined]  # by its kind
        return kind == self.goal == _REJECTED and self._is_of(event.robot, event.action)  # type: ignore[attr-defined]

    def matches_goal(self, robot: str, action: str, status: int) -> bool:
        """Return whether a change of a goal to a status matches."""
        return self.goal is not None and status in STATUSES[self.goal] and self._is_of(robot, action)

    def flaws(self) -> Iterator[Finding]:
        """Yield the errors that don't depend on the world: unknown kinds and fields."""
        if self.event is None:
            return
        kind = registry().get(self.event)
        if kind is None:
            message = f"there is no kind of event {self.event!r}{instead(self.event, registry())}"
            yield Finding(("event",), message, self.event)
            return
        if kind.rest:
            return
        fields = [field.rstrip("_") for field in kind._fields]
        for name in self.where:
            if name not in fields:
                yield Finding(("where", name), f"{self.event} has no field {name!r}{instead(name, fields)}", name)
        if self.robot is not None and "robot" not in fields:
            yield Finding(("robot",), f"{self.event} is not about a robot", self.robot)

    def describe(self) -> str:
        """Return the pattern in words, such as ``pickup of eve is accepted``."""
        if self.goal is not None:
            whose = f" of {self.robot}" if self.robot else ""
            return f"{self.action or 'a goal'}{whose} is {self.goal}"
        values = {**({"robot": self.robot} if self.robot else {}), **self.where}
        fields = ", ".join(f"{name} {value}" for name, value in values.items())
        return f"{self.event}{f' ({fields})' if fields else ''}"

    def _is_of(self, robot: str, action: str) -> bool:
        return self.robot in (None, robot) and self.action in (None, action)

    def _fits(self, event: Event) -> bool:
        if self.robot is not None and getattr(event, "robot", None) != self.robot:
            return False
        if not self.where:
            return True
        fields = event.to_json()
        return all(name in fields and fields[name] == value for name, value in self.where.items())
