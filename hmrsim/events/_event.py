"""The base of events: a named tuple with a kind, a severity, and a text that is data."""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Mapping
from enum import StrEnum
from functools import cache, partial
from typing import TYPE_CHECKING, Any, ClassVar, Final, NamedTuple, Self, dataclass_transform, get_type_hints

from pydantic import BaseModel, ConfigDict, Field, ValidationError, create_model
from pydantic.fields import FieldInfo

from hmrsim.events._parts import Change
from hmrsim.events._text import render

if TYPE_CHECKING:
    from hmrsim.events._text import Format

WORLD: Final = "_world"
"""The name under which the world serves actions."""


_ENVELOPE: Final = ("kind", "stamp")
"""Fields of each event's JSON that are not the event's own."""


class Severity(StrEnum):
    """The severity of an event for users; `DEBUG` is for events that are too frequent for a log."""

    DEBUG = "debug"
    INFO = "info"
    WARNING = "warning"
    ERROR = "error"


class Presentation(NamedTuple):
    """How events of a kind are shown; the page is given the same.

    Attributes:
        severity: A template (`hmrsim.events._text`) for one of `Severity`; for most kinds it has no fields.
        subject: Fields, of which the first one given names the subject; none for the whole world.
        text: A template for what happens to the subject.
    """

    severity: str
    subject: tuple[str, ...]
    text: str


@dataclass_transform(frozen_default=True)
class _EventType(type):
    """Makes a class a named tuple of its own fields and those of its base."""

    def __new__(mcs, name: str, bases: tuple[type, ...], namespace: dict[str, Any], **presentation: Any) -> _EventType:
        base = next((each for each in bases if isinstance(each, _EventType)), None)
        if base is not None:
            own = list(namespace.get("__annotations__", ()))
            fields: tuple[str, ...] = (*base._fields, *own)
            defaults = {**base._field_defaults, **{field: namespace.pop(field) for field in own if field in namespace}}
            made = partial(namedtuple, name, fields)(defaults=defaults.values(), module=namespace["__module__"])  # noqa: PYI024 - fields are typed in the class
            namespace |= {key: vars(made)[key] for key in (*fields, *_TAKEN)}
        return super().__new__(mcs, name, bases, {**namespace, "__slots__": ()}, **presentation)

    _fields: tuple[str, ...]
    _field_defaults: dict[str, Any]


_TAKEN: Final = ("__new__", "__match_args__", "__repr__", "__getnewargs__", "_fields", "_field_defaults")
"""The members that a class takes from a named tuple, besides its fields."""


class Event(tuple[Any, ...], metaclass=_EventType):
    """An event of the world, without its time.

    A subclass lists its fields, each annotated with its type and a `pydantic.Field` with a description. A field that
    has a default is left out of JSON while it has that value. In JSON a trailing underscore of a name is left out, as
    Python has keywords that fields are named by. A subclass without a `kind` is a base for others.

    It is a tuple, as one is made for each lane that a robot drives, and a frozen dataclass takes three times as long.

    Attributes:
        kind: Its name in traces, on the wire and in schemas.
        change: What it changes in a picture of the world; None for nothing.
        traced: Whether traces have it. They omit what a replay reproduces: how robots move from lane to lane.
        rest: The field, a mapping, whose entries are fields of their own in JSON; empty for none.
    """

    __slots__ = ()

    kind: ClassVar[str] = ""
    presentation: ClassVar[Presentation] = Presentation(Severity.INFO, ("robot",), "")
    change: ClassVar[Change | None] = None
    traced: ClassVar[bool] = True
    rest: ClassVar[str] = ""
    _fields: ClassVar[tuple[str, ...]] = ()
    _field_defaults: ClassVar[dict[str, Any]] = {}
    _names: ClassVar[tuple[str, ...]] = ()
    _optional: ClassVar[tuple[tuple[str, Any], ...]] = ()

    def __init_subclass__(
        cls,
        *,
        kind: str = "",
        severity: str = Severity.INFO,
        subject: tuple[str, ...] | None = None,
        text: str = "",
        changes: str = "",
        sets: Mapping[str, Any] | None = None,
        traced: bool = True,
        rest: str = "",
    ) -> None:
        """Declare a kind of event.

        Most arguments are the attributes of these names; *severity*, *subject* and *text* are its `Presentation`,
        *changes*, one of `Part`, and *sets* its `Change`. It has subject and part of its base if it states none.
        """
        if kind:
            cls.kind = kind
        cls.traced, cls.rest = traced, rest or cls.rest
        cls.presentation = Presentation(str(severity), cls.presentation.subject if subject is None else subject, text)
        part = str(changes) if changes else cls.change and cls.change.part
        cls.change = Change(part, sets or {}) if part else None
        cls._names = tuple(field.rstrip("_") for field in cls._fields)
        cls._optional = tuple((field.rstrip("_"), default) for field, default in cls._field_defaults.items())

    def __eq__(self, other: object) -> bool:
        """Return whether another event is of the same kind, and has the same fields."""
        return type(self) is type(other) and tuple.__eq__(self, other)

    def __ne__(self, other: object) -> bool:
        """Return the opposite."""
        return not self == other

    def __hash__(self) -> int:
        """Return the hash, which equal events share."""
        return tuple.__hash__(self)

    def as_dict(self) -> dict[str, Any]:
        """Return the fields by their names in JSON, without kind and time; arrays may be tuples."""
        fields = dict(zip(self._names, self, strict=False))
        for name, default in self._optional:
            if fields[name] == default:
                del fields[name]
        return self._spread(fields) if self.rest else fields

    def to_json(self) -> dict[str, Any]:
        """Return the same as JSON has it: with lists only."""
        return {name: _listed(value) for name, value in self.as_dict().items()}

    @classmethod
    def from_json(cls, fields: Mapping[str, Any]) -> Self:
        """Return the event that plain values stand for; fields that it does not have are passed over.

        Raises:
            ValueError: One is missing, or of another type.
        """
        if cls.rest:
            rest = {name: value for name, value in fields.items() if name not in (*cls._names, *_ENVELOPE)}
            fields = {**fields, cls.rest: rest}
        try:
            values = model_of(cls).model_validate(fields)
        except ValidationError as error:
            wrong = (f"{'.'.join(map(str, each['loc']))}: {each['msg']}" for each in error.errors(include_url=False))
            raise ValueError("; ".join(wrong)) from None
        return cls(**{field: getattr(values, field.rstrip("_") + "_") for field in cls._fields})

    @classmethod
    def fields(cls) -> tuple[str, ...] | None:
        """Return the names of its fields in JSON; None if it may have any further ones."""
        return None if cls.rest else cls._names

    def _spread(self, fields: dict[str, Any]) -> dict[str, Any]:
        """Return fields with the entries of `rest` in its place."""
        spread: dict[str, Any] = {}
        for name, value in fields.items():
            spread |= value if name == self.rest else {name: value}
        return spread

    @property
    def severity(self) -> Severity:
        """Its severity."""
        template = self.presentation.severity
        return Severity(render(template, self.as_dict()) if "{" in template else template)

    @property
    def subject(self) -> str:
        """The subject's name; empty for the whole world."""
        fields = self.as_dict()
        found = next((fields[name] for name in self.presentation.subject if fields.get(name) is not None), "")
        return "-".join(found) if isinstance(found, (list, tuple)) else "" if found == WORLD else str(found)

    def text(self, formats: Mapping[str, Format] | None = None) -> str:
        """Return what happens to its subject, as text; *formats* are further ones for its template."""
        return render(self.presentation.text, self.as_dict(), formats)

    def describe(self) -> str:
        """Return it as a sentence, without a full stop."""
        return f"{self.subject} {self.text()}".lstrip()


class EventGroup(NamedTuple):
    """The events of one subject: what a module of this package, or of a plug-in, offers as ``EVENTS``."""

    name: str
    events: tuple[type[Event], ...]


@cache
def model_of(event: type[Event]) -> type[BaseModel]:
    """Return the model of an event's JSON, which reads it and has its schema; its fields end with an underscore."""
    fields: dict[str, Any] = {}
    for name, hint in get_type_hints(event, include_extras=True).items():
        if name in event._fields:
            default = event._field_defaults.get(name, ...)
            plain = name.rstrip("_")
            fields[f"{plain}_"] = (hint, Field(default, alias=plain))
    return create_model(event.__name__, __config__=_CONFIG, __doc__=event.__doc__, **fields)


def description_of(event: type[Event], field: str) -> str:
    """Return the description of a field; empty if there is none."""
    hint = get_type_hints(event, include_extras=True)[field]
    said = (each.description for each in getattr(hint, "__metadata__", ()) if isinstance(each, FieldInfo))
    return next(filter(None, said), None) or ""


def _listed(value: Any) -> Any:
    return [_listed(each) for each in value] if isinstance(value, (list, tuple)) else value


_CONFIG: Final = ConfigDict(extra="ignore", allow_inf_nan=False)
