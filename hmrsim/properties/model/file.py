"""Files of properties: their model, and their reader, which reports all errors at once."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal, Self

from pydantic import BaseModel, BeforeValidator, Field, ValidationInfo, WithJsonSchema

from hmrsim.diagnostics import Finding, instead, limited, problems_of
from hmrsim.diagnostics import Path as Place
from hmrsim.documents.document import Document, read_document
from hmrsim.documents.valid_parts import valid_parts
from hmrsim.errors import PropertyError
from hmrsim.events import EventPattern, registry
from hmrsim.properties.model.part import BOUND, EACH, Count, Identifier, Part, Seconds, key_of, texts, walk
from hmrsim.properties.model.property import KINDS, DelayedReaction, InstantaneousReaction, Property, Whenever

if TYPE_CHECKING:
    from pathlib import Path

    from hmrsim.errors import Problem


def _default(value: Any, info: ValidationInfo) -> Any:
    """Return the default value of a property for which a file says ``true``."""
    return _DEFAULTS[info.field_name or ""] if value is True else value


_DEFAULTS: Final = {"no_deadlock": 60.0, "nobody_stranded": 120.0, "no_vain_goals": 5}

_ON_OR_OFF: Final = {"type": "boolean"}
_Limit = Annotated[
    Seconds | Literal[False],
    BeforeValidator(_default),
    WithJsonSchema({"anyOf": [{"type": "number", "exclusiveMinimum": 0, "maximum": 1e9}, _ON_OR_OFF]}),
]
_Times = Annotated[
    Count | Literal[False],
    BeforeValidator(_default),
    WithJsonSchema({"anyOf": [{"type": "integer", "minimum": 1, "maximum": 1_000_000}, _ON_OR_OFF]}),
]


class Recovery(Part):
    """The time in which a controller has to recover.

    Attributes:
        within: The longest single fault after which the mission must not fail, and the time after several faults.
    """

    within: Seconds


class BuiltIn(Part):
    """The properties that are built in, with their limits; ``false`` switches one off.

    Attributes:
        goals_end: Each accepted goal gets exactly one terminal status by the end of the run.
        no_deadlock: Robots do not wait for each other in a circle for longer than so many simulated seconds.
        nobody_stranded: No robot has an empty battery for longer than so many seconds without being charged.
        orders_in_time: No order is late or lost.
        controller_lives: The controller does not crash, hang, or run out of memory.
        no_vain_goals: The same goal to the same robot is not rejected or aborted so many times in a row.
        mission_ends: The controller ends before the limit of simulated time.
        recovers: The mission does not fail after transient faults; off by default.
    """

    goals_end: bool = True
    no_deadlock: _Limit = _DEFAULTS["no_deadlock"]
    nobody_stranded: _Limit = _DEFAULTS["nobody_stranded"]
    orders_in_time: bool = True
    controller_lives: bool = True
    no_vain_goals: _Times = 5
    mission_ends: bool = True
    recovers: Recovery | Literal[False] = False


class Properties(Part):
    """The properties of runs in a file, by name, and the built-in ones."""

    properties: dict[Identifier, Property] = Field(default={}, description="By name.")
    built_in: BuiltIn = BuiltIn()
    _file: str = "properties"
    _line: Callable[[Place], int | None] = lambda _path: None

    def located(self, file: str, line: Callable[[Place], int | None]) -> Self:
        """Return the same properties, with their file and a function that returns the line of a path in it."""
        copied = self.model_copy()
        copied._file, copied._line = file, line  # noqa: SLF001 - its own
        return copied

    @property
    def file(self) -> str:
        """The file as the user named it, or the name of another source."""
        return self._file

    def problems(self, findings: Iterable[Finding]) -> list[Problem]:
        """Return findings about these properties with their file and lines, in the order of the file."""
        return problems_of(findings, self._file, self._line)


_BINDING: Final = (Whenever, InstantaneousReaction, DelayedReaction)
"""Properties whose ``then`` may name fields of the trigger's event."""

_OF_GOALS: Final = ("robot", "action", "goal_id")
"""The fields that a trigger about a goal binds."""


def read_properties(path: str | Path) -> Properties:
    """Return the properties of a file, YAML or JSON.

    Raises:
        PropertyError: The file is invalid; it has all errors.
    """
    return _valid(*read_valid_properties(path))


def read_valid_properties(path: str | Path) -> tuple[Properties, list[Finding]]:
    """Return the valid properties of a file, YAML or JSON, and the errors of the others.

    Raises:
        PropertyError: The file can't be read, or is not a mapping.
    """
    document = read_document(path, PropertyError, "a mapping with properties, built_in or both")
    properties, findings = valid_properties(document)
    return properties, [*document.findings, *findings]


def properties_of(data: Mapping[str, Any], source: str = "properties") -> Properties:
    """Return the properties of a mapping, the content of a file; errors name *source*.

    Raises:
        PropertyError: The content is invalid; it has all errors.
    """
    return _valid(*valid_properties(Document(source, dict(data), PropertyError)))


def _valid(properties: Properties, findings: Sequence[Finding]) -> Properties:
    if findings:
        raise PropertyError(limited(properties.problems(findings), properties.file))
    return properties


def valid_properties(document: Document) -> tuple[Properties, list[Finding]]:
    """Return the valid properties of a document, and the errors."""
    valid = valid_parts(document.data, Properties)
    properties = (valid.value or Properties()).located(document.file, document.line)
    return properties, [*valid.findings, *_flaws(properties)]


def _flaws(properties: Properties) -> Iterator[Finding]:
    """Yield the errors in valid properties that do not depend on a world."""
    for name, each in properties.properties.items():
        path = ("properties", name)
        if name in BuiltIn.model_fields:
            yield Finding(path, f"{name!r} is a property that is built in; give another name", name)
        for inner, part in walk(each, path):
            if isinstance(part, EventPattern):
                yield from (flaw.within(*inner) for flaw in part.flaws())
                yield from (
                    Finding((*inner, "where", key), f"for each robot, put robot: {EACH!r} beside where", value)
                    for key, value in part.where.items()
                    if value == EACH
                )
        yield from _unbound(path, each)
        yield from _twice(path, each)


def _unbound(path: Place, part: BaseModel) -> Iterator[Finding]:
    """Yield an error for each ``$field`` that no trigger binds."""
    bound, inside = list[str](), set[int]()
    trigger = getattr(part, key_of(part, KINDS) or "")
    if isinstance(trigger, EventPattern) and isinstance(part, _BINDING):
        bound, inside = _fields_of(trigger), {id(each) for _, each in walk(part.then)}
    for inner, each in walk(part, path):
        for key, value in texts(each):
            if not value.startswith(BOUND):
                continue
            if id(each) not in inside:
                message = f"{value!r} stands for a field of a trigger's event; it can be used in `then` of one"
                yield Finding((*inner, *key), message, value)
            elif value[1:] not in bound:
                message = f"the trigger has no field {value[1:]!r}{instead(value[1:], bound)}"
                yield Finding((*inner, *key), message, value)


_ORDERED: Final = (
    "ordered_visit",
    "strict_ordered_visit",
    "fair_visit",
    "ordered_patrolling",
    "strict_ordered_patrolling",
    "fair_patrolling",
)
"""The patterns that no run can satisfy if they contain a place twice."""


def _twice(path: Place, part: BaseModel) -> Iterator[Finding]:
    for field in _ORDERED:
        places = getattr(part, field, ())
        for i, place in enumerate(places):
            if place in places[:i]:
                message = f"{place!r} is there already; a place can have one position in an order"
                yield Finding((*path, field, i), message, place)


def _fields_of(trigger: EventPattern) -> list[str]:
    """Return the fields that a trigger's event binds."""
    if trigger.goal is not None:
        return [*_OF_GOALS]
    kind = registry().get(trigger.event or "")
    fields = [] if kind is None else [name.rstrip("_") for name in kind._fields if name != kind.rest]
    return [*fields, *(["robot"] if kind is not None and kind.rest and "robot" not in fields else [])]
