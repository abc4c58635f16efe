"""How the fields of a type lie in bytes: what `encoders` and `decoders` make their code from.

Nested messages have no bytes of their own, so a type is a row of leaves: numbers, texts and lists.
Numbers side by side are one run, packed at once; how much padding is in it depends on where it begins.
"""

from __future__ import annotations

import struct
from functools import cache
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from hmrsim_zenoh.ros2.codec.rihs01 import Field, Kind, Structure

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping

HEADER: Final = 4
"""Bytes of the encapsulation before a message; alignment counts from there."""

LITTLE_ENDIAN: Final = b"\0\1\0\0"
"""The encapsulation of what we write."""

MAX_ALIGNMENT: Final = 8
"""Bytes to which the largest numbers are aligned: where a run begins matters only modulo this."""

MAX_ITEMS: Final = 10_000
"""Messages and texts that the lists of one message may have, nested ones counted: each takes microseconds to check."""

TOO_MANY: Final = f"more than {MAX_ITEMS} messages and texts in the lists of one message"

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
"""The primitives of fixed size, as the module `struct` names them."""


class Leaf(NamedTuple):
    """A field that nests nothing but in a list.

    Attributes:
        field: Which.
        path: The names under which our message has its value, from the outermost; None if it has none.
    """

    field: Field
    path: tuple[str, ...] | None


def leaves(described: Structure, within: tuple[str, ...] | None = ()) -> Iterator[Leaf]:
    """Give all that is in a type's bytes, in order."""
    for field in described.fields:
        path = None if within is None or field.path is None else within + field.path
        if field.nested is not None and field.kind is Kind.SINGLE:
            yield from leaves(field.nested, path)
        else:
            yield Leaf(field, path)


def containers(described: Structure) -> Iterator[tuple[str, ...]]:
    """Give the path of each nested message that isn't in a list, the outer ones first."""
    for field in described.fields:
        if field.path is not None and field.nested is not None and field.kind is Kind.SINGLE:
            if field.path:
                yield field.path
            yield from (field.path + path for path in containers(field.nested))


@cache
def weight(field: Field) -> int:
    """Return what one item of a list counts towards `MAX_ITEMS`: the messages in it; a number counts nothing."""
    if field.nested is not None:
        return 1 + sum(1 for _ in containers(field.nested))
    return 1 if field.primitive == "string" else 0


def padding(at: int, size: int) -> int:
    """Return how many bytes are between *at* and the next place for a number of *size* bytes."""
    return (HEADER - at) % size


@cache
def size_of(code: str) -> int:
    """Return the bytes of a number, by its format."""
    return struct.calcsize(f"<{code}")


@cache
def least_size(field: Field) -> int:
    """Return the fewest bytes that one item of a field can have; one at least, as no ROS type is empty."""
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
    """Numbers side by side, each as ``d`` or ``36d``; ``x`` is a padding byte."""

    codes: tuple[str, ...]

    def packed(self, at: int) -> struct.Struct:
        """Return what packs and unpacks them where they begin at *at*."""
        return _struct(self._format(at))

    def each(self, take: Callable[[struct.Struct], Any]) -> tuple[Any, ...]:
        """Return something of `packed` for each place where a run can begin, modulo `MAX_ALIGNMENT`."""
        return tuple(take(self.packed(at)) for at in range(MAX_ALIGNMENT))

    @property
    def shifts(self) -> bool:
        """Whether its padding depends on where it begins."""
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
