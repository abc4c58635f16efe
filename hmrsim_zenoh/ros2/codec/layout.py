"""The layout of a type's fields in bytes, from which `encoders` and `decoders` generate code.

Nested messages have no bytes of their own, so a type is a sequence of leaves: numbers, strings and lists.
Adjacent numbers form a run, which is packed at once; its padding depends on its offset.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from types import MappingProxyType
from typing import Any, Final, NamedTuple

from hmrsim_zenoh.ros2.codec.structures import Field, Kind, Structure

HEADER: Final = 4
"""Bytes of the encapsulation before a message; alignment counts from there."""

LITTLE_ENDIAN: Final = b"\0\1\0\0"
"""The encapsulation of written messages."""

MAX_ALIGNMENT: Final = 8
"""The alignment of the largest numbers in bytes: the offset of a run matters only modulo this."""

MAX_ITEMS: Final = 10_000
"""The largest number of messages and strings in all lists of one message: each takes microseconds to check."""

TOO_MANY: Final = f"more than {MAX_ITEMS} messages and strings in the lists of one message"

FORMATS: Final[Mapping[str, str]] = MappingProxyType(
    {
        "int8": "b",
        "uint8": "B",
        "int16": "h",
        "uint16": "H",
        "int32": "i",
        "uint32": "I",
        "int64": "q",
        "uint64": "Q",
        "float": "f",
        "double": "d",
        "boolean": "?",
        "byte": "B",
    }
)
"""The primitives of fixed size and their formats in the module `struct`."""


class Leaf(NamedTuple):
    """A field that is not a single nested message.

    Attributes:
        path: The path of the value in our message, outermost name first; None if our message lacks it.
    """

    field: Field
    path: tuple[str, ...] | None


def leaves(described: Structure, within: tuple[str, ...] | None = ()) -> Iterator[Leaf]:
    """Yield the leaves of a type in the order of its bytes."""
    for field in described.fields:
        path = None if within is None or field.path is None else within + field.path
        if field.nested is not None and field.kind is Kind.SINGLE:
            yield from leaves(field.nested, path)
        else:
            yield Leaf(field, path)


def containers(described: Structure) -> Iterator[tuple[str, ...]]:
    """Yield the path of each nested message that is not in a list, the outer ones first."""
    for field in described.fields:
        if field.path is not None and field.nested is not None and field.kind is Kind.SINGLE:
            if field.path:
                yield field.path
            yield from (field.path + path for path in containers(field.nested))


@cache
def weight(field: Field) -> int:
    """Return the weight of one list item towards `MAX_ITEMS`: the number of messages in it; 0 for a number."""
    if field.nested is not None:
        return 1 + sum(1 for _ in containers(field.nested))
    return 1 if field.primitive == "string" else 0


def padding(at: int, size: int) -> int:
    """Return the number of padding bytes at *at* before a number of *size* bytes."""
    return (HEADER - at) % size


@cache
def size_of(code: str) -> int:
    """Return the size of a number in bytes, by its format."""
    return struct.calcsize(f"<{code}")


@cache
def least_size(field: Field) -> int:
    """Return the smallest size of one item of a field in bytes; at least 1, as no ROS type is empty."""
    if field.nested is not None:
        return sum(_least(leaf.field) for leaf in leaves(field.nested))
    return size_of("I" if field.primitive == "string" else FORMATS[field.primitive])


def _least(field: Field) -> int:
    match field.kind:
        case Kind.SINGLE:
            return least_size(field)
        case Kind.ARRAY:
            return least_size(field) * field.capacity
    return size_of("I")


class Run(NamedTuple):
    """Adjacent numbers, each as ``d`` or ``36d``; ``x`` is a padding byte."""

    codes: tuple[str, ...]

    def packed(self, at: int) -> struct.Struct:
        """Return the struct of the run at the offset *at*."""
        return _struct(self._format(at))

    def each(self, use: Callable[[struct.Struct], Any]) -> tuple[Any, ...]:
        """Return *use* of the struct for each offset modulo `MAX_ALIGNMENT`."""
        return tuple(use(self.packed(at)) for at in range(MAX_ALIGNMENT))

    @property
    def shifts(self) -> bool:
        """Whether the padding depends on the offset."""
        return any(code[-1] not in "xsbB?" for code in self.codes)

    def _format(self, at: int) -> str:
        parts = ["<"]
        for code in self.codes:
            pad = padding(at, size_of(code[-1]))
            parts.append(f"{pad}x{code}" if pad else code)
            at += pad + size_of(code)
        return "".join(parts)


@cache
def _struct(form: str) -> struct.Struct:
    return struct.Struct(form)
