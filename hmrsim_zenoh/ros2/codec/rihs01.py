"""ROS type descriptions and their RIHS01 hashes, derived from the message models.

A ROS key ends in the type's hash, so a peer whose fields differ in name, order or type is never matched.
The hash is the SHA-256 of the type description as JSON: names and types of fields count; constants, defaults
and comments don't. The dictionaries are those of ``type_description_interfaces/msg/TypeDescription``.
"""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Any, Final, get_args, get_origin

from hmrsim.interfaces.message import Array, Message, Primitive

if TYPE_CHECKING:
    from collections.abc import Iterable

_TYPE_IDS: Final = MappingProxyType(
    {
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
_NESTED: Final = 1
_FIXED, _BOUNDED, _UNBOUNDED = 48, 96, 144


@dataclass(frozen=True)
class FieldType:
    """What a field holds.

    Attributes:
        type_id: The number of the type, with the offset of an array.
        capacity: Items of a fixed array, or the most that a bounded sequence may have; else 0.
        nested: The structure that is nested, or None for a primitive.
    """

    type_id: int
    capacity: int = 0
    nested: Structure | None = None


@dataclass(frozen=True)
class Structure:
    """A ROS type: its name, and its fields in order.

    What ROS derives from an action or a service, and has no model, can be written down as one, too.
    """

    name: str
    fields: tuple[tuple[str, FieldType], ...]

    def describe(self) -> dict[str, Any]:
        """Return the description of this type and of all that it nests, in the order that is hashed."""
        nested: dict[str, Structure] = {}
        _collect(self, nested)
        return {
            "type_description": _individual(self),
            "referenced_type_descriptions": [_individual(nested[name]) for name in sorted(nested)],
        }

    def hash(self) -> str:
        """Return ``RIHS01_`` and the hash in hex."""
        # Python's separators and ASCII escapes are those of ROS's generator.
        text = json.dumps(self.describe())
        return f"RIHS01_{hashlib.sha256(text.encode()).hexdigest()}"


# C and C++ have no empty structures, so ROS puts this field into a message that has none.
_PADDING: Final = ("structure_needs_at_least_one_member", FieldType(_TYPE_IDS["uint8"]))


@cache
def structure(cls: type[Message]) -> Structure:
    """Return the ROS type that a model stands for.

    Raises:
        TypeError: A field has no ROS type.
    """
    fields = []
    for name, info in cls.model_fields.items():
        try:
            fields.append((name, _field_type(info.annotation, info.metadata)))
        except TypeError as error:
            raise TypeError(f"{cls.ros_type}: field {name!r}: {error}") from None
    return Structure(cls.ros_type, tuple(fields) or (_PADDING,))


def type_description(cls: type[Message]) -> dict[str, Any]:
    """Return a message's description, as in ``type_description_interfaces/msg/TypeDescription``."""
    return structure(cls).describe()


@cache
def rihs01(cls: type[Message]) -> str:
    """Return a message's hash, such as ``RIHS01_4bee5d…``."""
    return structure(cls).hash()


def _collect(outer: Structure, found: dict[str, Structure]) -> None:
    for _, field in outer.fields:
        if field.nested is not None and field.nested.name not in found:
            found[field.nested.name] = field.nested
            _collect(field.nested, found)


def _individual(described: Structure) -> dict[str, Any]:
    return {
        "type_name": described.name,
        "fields": [
            {
                "name": name,
                "type": {
                    "type_id": field.type_id,
                    "capacity": field.capacity,
                    "string_capacity": 0,
                    "nested_type_name": field.nested.name if field.nested else "",
                },
            }
            for name, field in described.fields
        ],
    }


def _field_type(annotation: object, metadata: Iterable[object]) -> FieldType:
    if get_origin(annotation) is Annotated:
        annotation, *metadata = get_args(annotation)
    if get_origin(annotation) is not list:
        return _item_type(annotation, metadata)
    item = _field_type(get_args(annotation)[0], ())
    array = next((mark for mark in metadata if isinstance(mark, Array)), None)
    if array is None:
        return FieldType(item.type_id + _UNBOUNDED, nested=item.nested)
    return FieldType(item.type_id + (_BOUNDED if array.bounded else _FIXED), array.size, item.nested)


def _item_type(annotation: object, metadata: Iterable[object]) -> FieldType:
    if isinstance(annotation, type) and issubclass(annotation, Message):
        return FieldType(_NESTED, nested=structure(annotation))
    for mark in metadata:
        if isinstance(mark, Primitive):
            return FieldType(_TYPE_IDS[mark.name])
    raise TypeError(f"{annotation!r} has no ROS type; a Message or a primitive of interfaces.message has")
