"""ROS types in the format of ``.msg`` files, with which a recording describes its messages to other tools.

The text is that of rosbag2, ``ros2msg`` in MCAP: the type, then all that it nests, each after a line of ``=``.
Constants come from our models; defaults, comments and the padding of empty types are left out.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import Final, get_args

from hmrsim.interfaces.message import Message
from hmrsim_zenoh.ros2.codec.rihs01 import PADDING, Field, Kind, Structure

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


def _collect_constants(model: type[Message], found: dict[str, dict[str, int]]) -> None:
    if model.ros_type in found:
        return
    found[model.ros_type] = {
        name: value for name, value in vars(model).items() if name.isupper() and isinstance(value, int)
    }
    for info in model.model_fields.values():
        for nested in _messages_in(info.annotation):
            _collect_constants(nested, found)


def _messages_in(annotation: object) -> Iterator[type[Message]]:
    if isinstance(annotation, type) and issubclass(annotation, Message):
        yield annotation
    for part in get_args(annotation):
        yield from _messages_in(part)
