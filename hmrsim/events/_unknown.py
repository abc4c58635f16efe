"""Events of kinds that are not known here."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Self

from hmrsim.events._event import Event, Severity
from hmrsim.events._text import plain

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
