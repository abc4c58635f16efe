"""The base of events: a named tuple with a kind, a severity, and a text that is data, and common types of fields."""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Mapping
from enum import StrEnum
from functools import cache, partial
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Final, NamedTuple, Self, dataclass_transform, get_type_hints

from pydantic import BaseModel, ConfigDict, Field, ValidationError, create_model
from pydantic.fields import FieldInfo

from hmrsim.events._text import render

if TYPE_CHECKING:
    from hmrsim.events._text import Format


class Part(StrEnum):
    """A part of the scene that an event changes; most are fields of ``_world/scene``.

    The page updates its scene by the part that an event declares, never by the event's kind.
    """

    MOTION = "robots.motion"
    ROUTE = "robots.route"
    POSE = "robots.pose"
    WAITING = "robots.waiting"
    YIELDING = "robots.yielding"
    GOALS = "robots.goals"
    DOCK = "robots.dock"
    BATTERY = "robots.battery"
    SCRIPT = "robots.script"
    CARRIER = "items.carrier"
    ENTITIES = "entities"
    DOOR = "fixtures.door"
    LIFT = "fixtures.lift"
    CLOSED_LANES = "closed_lanes"
    DEADLOCKS = "deadlocks"
    FAULTS = "faults"
    ORDERS = "orders"
    PARTICIPANTS = "participants"
    PLANNER = "planner_present"
    STATE = "simulation_state"
    SCENE = "scene"
    WORLD = "world"


class Change(NamedTuple):
    """The change of the scene by events of a kind.

    Attributes:
        part: The part of the scene; one of `Part`.
        sets: Values besides the event's fields, which distinguish the kinds that change the same part.
    """

    part: str
    sets: Mapping[str, Any]


Number = Annotated[float, Field(strict=True)]
Whole = Annotated[int, Field(strict=True)]

RobotName = Annotated[str, Field(description="The robot's name.")]
RobotNames = Annotated[tuple[str, ...], Field(description="The robots' names.")]
ActionName = Annotated[str, Field(description="The action's name, such as `navigate_to_pose`.")]
GoalId = Annotated[str, Field(description="The goal's id: 32 hex digits.")]
Position = Annotated[tuple[Number, Number], Field(description="Where: x, y in the world's unit.")]
LaneName = Annotated[tuple[str, str], Field(description="The lane: the waypoints where it begins and ends.")]


WORLD: Final = "_world"
"""The name under which the world serves actions."""

_ENVELOPE: Final = ("kind", "stamp")
"""Keys that every event has in JSON, besides its fields."""


class Severity(StrEnum):
    """The severity of an event for users; `DEBUG` is for events that are too frequent for a log."""

    DEBUG = "debug"
    INFO = "info"
    WARNING = "warning"
    ERROR = "error"


class Presentation(NamedTuple):
    """The presentation of a kind of event, here and on the page.

    Attributes:
        severity: A template (`hmrsim.events._text`) for one of `Severity`; most kinds need no fields in it.
        subject: Fields, the first present one of which names the subject; empty for the whole world.
        text: A template for what happens to the subject.
    """

    severity: str
    subject: tuple[str, ...]
    text: str


@dataclass_transform(frozen_default=True)
class _EventType(type):
    """Turn a class into a named tuple of its fields and those of its base."""

    def __new__(mcs, name: str, bases: tuple[type, ...], namespace: dict[str, Any], **presentation: Any) -> _EventType:
        base = next((parent for parent in bases if isinstance(parent, _EventType)), None)
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
"""The members of a named tuple that a class takes over, besides its fields."""


class Event(tuple[Any, ...], metaclass=_EventType):
    """An event of the world, without its time.

    A subclass lists its fields, each annotated with its type and a `pydantic.Field` with a description. JSON omits a
    field that has its default value, and the trailing underscore of names that are Python keywords. A subclass without
    a `kind` is a base for others.

    It is a tuple because each lane that a robot drives creates one, and a frozen dataclass takes three times as long.

    Attributes:
        kind: The name in traces, on the wire and in schemas.
        change: The change of the scene, or None.
        traced: Whether traces contain it. They omit motion from lane to lane, which a replay reproduces.
        rest: The mapping field whose entries become fields in JSON; empty for none.
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

        *severity*, *subject* and *text* make up its `Presentation`. *changes*, one of `Part`, and *sets* make up its
        `Change`. Other arguments set the attributes of the same names. Subject and part default to those of the base.
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
        """Return whether another event has the same kind and fields."""
        return type(self) is type(other) and tuple.__eq__(self, other)

    def __ne__(self, other: object) -> bool:
        """Return whether kind or fields differ."""
        return not self == other

    def __hash__(self) -> int:
        """Return the hash of the fields."""
        return tuple.__hash__(self)

    def as_dict(self) -> dict[str, Any]:
        """Return the fields by their JSON names, without kind and time; arrays may be tuples."""
        fields = dict(zip(self._names, self, strict=False))
        for name, default in self._optional:
            if fields[name] == default:
                del fields[name]
        return self._spread(fields) if self.rest else fields

    def to_json(self) -> dict[str, Any]:
        """Return the fields by their JSON names, with arrays as lists."""
        return {name: _listed(value) for name, value in self.as_dict().items()}

    @classmethod
    def from_json(cls, fields: Mapping[str, Any]) -> Self:
        """Return the event with the given JSON fields; unknown fields are ignored.

        Raises:
            ValueError: A field is missing or has the wrong type.
        """
        if cls.rest:
            rest = {name: value for name, value in fields.items() if name not in (*cls._names, *_ENVELOPE)}
            fields = {**fields, cls.rest: rest}
        try:
            values = model_of(cls).model_validate(fields)
        except ValidationError as error:
            flaws = (f"{'.'.join(map(str, flaw['loc']))}: {flaw['msg']}" for flaw in error.errors(include_url=False))
            raise ValueError("; ".join(flaws)) from None
        return cls(**{field: getattr(values, field.rstrip("_") + "_") for field in cls._fields})

    @classmethod
    def fields(cls) -> tuple[str, ...] | None:
        """Return the JSON names of the fields, or None if it can have any further fields."""
        return None if cls.rest else cls._names

    def _spread(self, fields: dict[str, Any]) -> dict[str, Any]:
        """Return the fields, with `rest` replaced by its entries."""
        spread: dict[str, Any] = {}
        for name, value in fields.items():
            spread |= value if name == self.rest else {name: value}
        return spread

    @property
    def severity(self) -> Severity:
        """The severity of this event."""
        template = self.presentation.severity
        return Severity(render(template, self.as_dict()) if "{" in template else template)

    @property
    def subject(self) -> str:
        """The name of the subject; empty for the whole world."""
        fields = self.as_dict()
        subject = next((fields[name] for name in self.presentation.subject if fields.get(name) is not None), "")
        return "-".join(subject) if isinstance(subject, (list, tuple)) else "" if subject == WORLD else str(subject)

    def text(self, formats: Mapping[str, Format] | None = None) -> str:
        """Return the event as text without its subject; *formats* are further formats of its template."""
        return render(self.presentation.text, self.as_dict(), formats)

    def describe(self) -> str:
        """Return the event as a sentence, without a full stop."""
        return f"{self.subject} {self.text()}".lstrip()


class EventGroup(NamedTuple):
    """The events of one subject."""

    name: str
    events: tuple[type[Event], ...]


@cache
def model_of(event: type[Event]) -> type[BaseModel]:
    """Return the pydantic model of an event's JSON; its fields end with an underscore."""
    fields: dict[str, Any] = {}
    for name, hint in get_type_hints(event, include_extras=True).items():
        if name in event._fields:
            default = event._field_defaults.get(name, ...)
            plain = name.rstrip("_")
            fields[f"{plain}_"] = (hint, Field(default, alias=plain))
    return create_model(event.__name__, __config__=_CONFIG, __doc__=event.__doc__, **fields)


def description_of(event: type[Event], field: str) -> str:
    """Return the description of a field, or an empty text."""
    hint = get_type_hints(event, include_extras=True)[field]
    descriptions = (mark.description for mark in getattr(hint, "__metadata__", ()) if isinstance(mark, FieldInfo))
    return next(filter(None, descriptions), None) or ""


def _listed(value: Any) -> Any:
    return [_listed(item) for item in value] if isinstance(value, (list, tuple)) else value


_CONFIG: Final = ConfigDict(extra="ignore", allow_inf_nan=False)
