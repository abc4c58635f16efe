"""ROS types derived from the message models: their descriptions, RIHS01 hashes and ``.msg`` definitions.

A ROS key ends with the type's hash, so a peer whose fields differ in name, order or type never matches.
The hash is the SHA-256 of the type description as JSON: names and types of fields count. Constants, defaults
and comments don't. The dictionaries are those of ``type_description_interfaces/msg/TypeDescription``.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from enum import IntEnum
from functools import cache
from types import MappingProxyType
from typing import Annotated, Any, Final, get_args, get_origin

from hmrsim.interfaces.builtin_interfaces import Time
from hmrsim.interfaces.message import Array, Message, Primitive
from hmrsim.interfaces.service_msgs import ServiceEventInfo
from hmrsim.interfaces.unique_identifier_msgs import UUID

_TYPE_IDS: Final = MappingProxyType(
    {
        "": 1,  # nested
        "int8": 2,
        "uint8": 3,
        "int16": 4,
        "uint16": 5,
        "int32": 6,
        "uint32": 7,
        "int64": 8,
        "uint64": 9,
        "float": 10,
        "double": 11,
        "boolean": 15,
        "byte": 16,
        "string": 17,
        "bounded string": 21,
    }
)
_OFFSET: Final = 48


class Kind(IntEnum):
    """The kind of a field: a single value, an array or a sequence."""

    SINGLE = 0
    ARRAY = 1
    BOUNDED = 2
    UNBOUNDED = 3


@dataclass(frozen=True)
class Field:
    """One field of a ROS type.

    Attributes:
        primitive: The primitive type of its values; empty for a nested type.
        kind: Whether it is a single value, an array or a sequence.
        capacity: The length of a fixed array, or the largest one of a bounded sequence; else 0.
        string_capacity: The largest length of a bounded string; else 0.
        nested: The nested structure, or None for a primitive.
        path: The path of the value in our message, outermost name first; None if our message lacks it.
            With the empty path, our outer message has the fields of the nested structure itself.
    """

    name: str
    primitive: str = ""
    kind: Kind = Kind.SINGLE
    capacity: int = 0
    nested: Structure | None = None
    path: tuple[str, ...] | None = None
    string_capacity: int = 0

    @property
    def type_id(self) -> int:
        """The number of the type, with the offset of an array."""
        return _TYPE_IDS["bounded string" if self.string_capacity else self.primitive] + _OFFSET * self.kind


@dataclass(frozen=True, eq=False)
class Structure:
    """A ROS type: its name, and its fields in order.

    Types that ROS derives from an action or a service, without a model, are structures, too.
    """

    name: str
    fields: tuple[Field, ...]

    def all_nested(self) -> dict[str, Structure]:
        """Return all types that this one nests by name, each before those that it nests itself."""
        types: dict[str, Structure] = {}
        self._collect(types)
        return types

    def _collect(self, types: dict[str, Structure]) -> None:
        for field in self.fields:
            if field.nested is not None and field.nested.name not in types:
                types[field.nested.name] = field.nested
                field.nested._collect(types)  # noqa: SLF001 - of the same class

    def describe(self) -> dict[str, Any]:
        """Return the description of this type and of all types that it nests, in the order of the hash."""
        nested = self.all_nested()
        return {
            "type_description": _individual(self),
            "referenced_type_descriptions": [_individual(nested[name]) for name in sorted(nested)],
        }

    def hash(self) -> str:
        """Return ``RIHS01_`` and the hash in hex."""
        # Python's separators and ASCII escapes are those of ROS's generator.
        text = json.dumps(self.describe())
        return f"RIHS01_{hashlib.sha256(text.encode()).hexdigest()}"


# C and C++ have no empty structures, so ROS adds this field to a message without fields.
PADDING: Final = Field("structure_needs_at_least_one_member", "uint8")


@cache
def structure(cls: type[Message]) -> Structure:
    """Return the ROS type of a model, whose fields all have one."""
    fields = tuple(_field(name, info.annotation, info.metadata) for name, info in cls.model_fields.items())
    return Structure(cls.ros_type, fields or (PADDING,))


def _individual(described: Structure) -> dict[str, Any]:
    return {
        "type_name": described.name,
        "fields": [
            {
                "name": field.name,
                "type": {
                    "type_id": field.type_id,
                    "capacity": field.capacity,
                    "string_capacity": field.string_capacity,
                    "nested_type_name": field.nested.name if field.nested else "",
                },
            }
            for field in described.fields
        ],
    }


def _field(name: str, annotation: object, metadata: Iterable[object]) -> Field:
    if get_origin(annotation) is Annotated:
        annotation, *metadata = get_args(annotation)
    if get_origin(annotation) is not list:
        return _single(name, annotation, metadata)
    item = _field(name, get_args(annotation)[0], ())
    array = next((mark for mark in metadata if isinstance(mark, Array)), None)
    if array is None:
        return replace(item, kind=Kind.UNBOUNDED)
    return replace(item, kind=Kind.BOUNDED if array.bounded else Kind.ARRAY, capacity=array.size)


def _single(name: str, annotation: object, metadata: Iterable[object]) -> Field:
    if isinstance(annotation, type) and issubclass(annotation, Message):
        return Field(name, nested=structure(annotation), path=(name,))
    primitive = next(mark for mark in metadata if isinstance(mark, Primitive))
    return Field(name, primitive.name, path=(name,), string_capacity=primitive.capacity)


@cache
def service_structure(name: str, request: Structure, response: Structure) -> Structure:
    """Return the type of a service, which is never serialized and only determines the service's hash."""
    event = Structure(
        f"{name}_Event",
        (
            _nested("info", structure(ServiceEventInfo)),
            Field("request", kind=Kind.BOUNDED, capacity=1, nested=request, path=("request",)),
            Field("response", kind=Kind.BOUNDED, capacity=1, nested=response, path=("response",)),
        ),
    )
    return Structure(
        name,
        (_nested("request_message", request), _nested("response_message", response), _nested("event_message", event)),
    )


@cache
def send_goal_structures(action: str, goal: Structure) -> tuple[Structure, Structure]:
    """Return request and response of an action's send_goal service."""
    request = Structure(f"{action}_SendGoal_Request", (_goal_id(), _nested("goal", goal)))
    accepted = Field("accepted", "boolean", path=("accepted",))
    return request, Structure(f"{action}_SendGoal_Response", (accepted, _nested("stamp", structure(Time))))


@cache
def get_result_structures(action: str, result: Structure) -> tuple[Structure, Structure]:
    """Return request and response of an action's get_result service."""
    request = Structure(f"{action}_GetResult_Request", (_goal_id(),))
    status = Field("status", "int8", path=("status",))
    return request, Structure(f"{action}_GetResult_Response", (status, _nested("result", result)))


@cache
def feedback_structure(action: str, feedback: Structure) -> Structure:
    """Return the message of an action's feedback topic."""
    return Structure(f"{action}_FeedbackMessage", (_goal_id(), _nested("feedback", feedback)))


def _goal_id() -> Field:
    return _nested("goal_id", structure(UUID))


def _nested(name: str, held: Structure) -> Field:
    return Field(name, nested=held, path=(name,))


_SEPARATOR: Final = "=" * 80
_WORDS: Final = {"float": "float32", "double": "float64", "boolean": "bool"}
"""The primitives whose names in ``.msg`` files differ from those in type descriptions."""


@cache
def definition(described: Structure, *models: type[Message]) -> str:
    """Return the definition of a type and of all types that it nests.

    Args:
        described: The type.
        models: Messages whose constants are included, along with those of nested messages.
    """
    constants: dict[str, dict[str, int]] = {}
    for model in models:
        _collect_constants(model, constants)
    parts = [_own(described, constants)]
    parts += [
        f"{_SEPARATOR}\nMSG: {_short(one.name)}\n{_own(one, constants)}" for one in described.all_nested().values()
    ]
    return "".join(parts)


def _own(described: Structure, constants: dict[str, dict[str, int]]) -> str:
    """Return the definition of one type without nested types: its constants, then its fields."""
    values = constants.get(described.name, {})
    lines = [f"{_type_of_constant(described, name, values)} {name}={value}" for name, value in values.items()]
    lines += [f"{_type(field)} {field.name}" for field in described.fields if field is not PADDING]
    return "".join(f"{line}\n" for line in lines)


def _type(field: Field) -> str:
    held = _short(field.nested.name) if field.nested else _WORDS.get(field.primitive, field.primitive)
    if field.string_capacity:
        held = f"{held}<={field.string_capacity}"
    match field.kind:
        case Kind.SINGLE:
            return held
        case Kind.ARRAY:
            return f"{held}[{field.capacity}]"
        case Kind.BOUNDED:
            return f"{held}[<={field.capacity}]"
    return f"{held}[]"


def _type_of_constant(described: Structure, name: str, constants: dict[str, int]) -> str:
    """Return the type of the field that a constant is for: the one of its name, else the first that can hold it."""
    whole = [field for field in described.fields if "int" in field.primitive and field.kind is Kind.SINGLE]
    named = next((field for field in whole if name.startswith(f"{field.name.upper()}_")), None)
    if named is not None:
        return named.primitive
    signed = min(constants.values()) < 0
    return next((one.primitive for one in whole if not (signed and one.primitive.startswith("u"))), "int32")


def _short(name: str) -> str:
    """Return a type's name as fields spell it, without ``msg``, ``srv`` or ``action``."""
    package, _, short = name.split("/")
    return f"{package}/{short}"


def _collect_constants(model: type[Message], constants: dict[str, dict[str, int]]) -> None:
    if model.ros_type in constants:
        return
    constants[model.ros_type] = {
        name: value for name, value in vars(model).items() if name.isupper() and isinstance(value, int)
    }
    for info in model.model_fields.values():
        for nested in _messages_in(info.annotation):
            _collect_constants(nested, constants)


def _messages_in(annotation: object) -> Iterator[type[Message]]:
    if isinstance(annotation, type) and issubclass(annotation, Message):
        yield annotation
    for part in get_args(annotation):
        yield from _messages_in(part)
