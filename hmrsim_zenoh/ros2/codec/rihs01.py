"""ROS type descriptions and their RIHS01 hashes, derived from the message models.

A ROS key ends with the type's hash, so a peer whose fields differ in name, order or type never matches.
The hash is the SHA-256 of the type description as JSON: names and types of fields count; constants, defaults
and comments don't. The dictionaries are those of ``type_description_interfaces/msg/TypeDescription``.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from dataclasses import dataclass, replace
from enum import IntEnum
from functools import cache
from types import MappingProxyType
from typing import Annotated, Any, Final, get_args, get_origin

from hmrsim.interfaces.message import Array, Message, Primitive

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

    @property
    def type_id(self) -> int:
        """The number of the type, with the offset of an array."""
        return _TYPE_IDS[self.primitive] + _OFFSET * self.kind


@dataclass(frozen=True, eq=False)
class Structure:
    """A ROS type: its name, and its fields in order.

    Types that ROS derives from an action or a service, without a model, are structures, too.
    """

    name: str
    fields: tuple[Field, ...]

    def all_nested(self) -> dict[str, Structure]:
        """Return all types that this one nests by name, each before those that it nests itself."""
        found: dict[str, Structure] = {}
        self._collect(found)
        return found

    def _collect(self, found: dict[str, Structure]) -> None:
        for field in self.fields:
            if field.nested is not None and field.nested.name not in found:
                found[field.nested.name] = field.nested
                field.nested._collect(found)  # noqa: SLF001 - of the same class

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
                    "string_capacity": 0,
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
    return Field(name, primitive.name, path=(name,))
