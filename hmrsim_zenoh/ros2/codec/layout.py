"""The layout of messages in CDR, from which the functions of `encoder` and `decoder` are generated.

A message is an encapsulation of four bytes and then its values, each aligned to its size. A nested message adds no
bytes to those of its fields, so a type is a sequence of leaves: numbers, strings and lists. Adjacent numbers form a
run, which is packed at once. Its padding depends on its offset.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache
from types import MappingProxyType
from typing import Any, Final, NamedTuple

from hmrsim_zenoh.ros2.codec.structures import Field, Kind, Structure

HEADER: Final = 4
"""Bytes of the encapsulation before a message; alignment counts from there."""

_MAX_ALIGNMENT: Final = 8
"""The alignment of the largest numbers in bytes: the offset of a run matters only modulo this."""

_UNALIGNED: Final = "xsbB?"
"""The formats of single bytes, which need no padding."""

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


class CdrError(ValueError):
    """Bytes are not a message of their type, or a value does not fit into its field."""


class Leaf(NamedTuple):
    """A field that is not a single nested message.

    Attributes:
        name: The name in the type, with the names of the enclosing fields: ``stamp.sec``.
        path: The path of the value in our message, outermost name first; None if our message lacks it.
    """

    name: str
    field: Field
    path: tuple[str, ...] | None


def leaves(described: Structure, name: str = "", within: tuple[str, ...] | None = ()) -> Iterator[Leaf]:
    """Yield the leaves of a type in the order of its bytes."""
    for field in described.fields:
        path = None if within is None or field.path is None else within + field.path
        if field.nested is not None and field.kind is Kind.SINGLE:
            yield from leaves(field.nested, f"{name}{field.name}.", path)
        else:
            yield Leaf(name + field.name, field, path)


def padding(at: int, size: int) -> int:
    """Return the number of padding bytes at *at* before a number of *size* bytes."""
    return (HEADER - at) % size


@cache
def size_of(code: str) -> int:
    """Return the size of a number, or of an array such as ``36d``, in bytes."""
    return struct.calcsize(f"<{code}")


class Code:
    """The source of a function for one type, and the values of the names in it.

    Args:
        at: The offset of the message in the bytes; None if it varies.
        order: The byte order, ``<`` or ``>``.

    Attributes:
        at: The offset of the next value in the bytes; None if it is known only at run time.
    """

    def __init__(self, names: Mapping[str, Any], at: int | None, order: str) -> None:
        self.lines: list[str] = []
        self.names: dict[str, Any] = dict(names)
        self.at = at
        self.order = order

    def run(self, codes: Sequence[str], use: Callable[[struct.Struct], Any]) -> tuple[str, str]:
        """Return an expression for a method of a run's struct, and the line that advances the position.

        Args:
            codes: The formats of the numbers, each such as ``d`` or ``36d``; ``x`` is a padding byte.
            use: Returns the method of a struct.
        """
        name = f"run{len(self.names)}"
        if self.at is None and any(code[-1] not in _UNALIGNED for code in codes):
            packed = [self._struct(codes, at) for at in range(_MAX_ALIGNMENT)]
            self.names[name] = tuple(map(use, packed))
            self.names[f"{name}_size"] = tuple(one.size for one in packed)
            return f"{name}[pos & 7]", f"pos += {name}_size[pos & 7]"
        one = self._struct(codes, self.at or 0)
        self.names[name] = use(one)
        if self.at is None:
            return name, f"pos += {one.size}"
        self.at += one.size
        return name, f"pos = {self.at}"

    def function(self, head: str, described: Structure) -> Any:
        """Return the generated function, whose first line is *head*."""
        source = "\n    ".join([head, *self.lines]) + "\n"
        exec(compile(source, f"<{head} of {described.name}>", "exec"), self.names)  # noqa: S102 - made of field names only
        return self.names[head[len("def ") : head.index("(")]]

    def _struct(self, codes: Sequence[str], at: int) -> struct.Struct:
        parts = [self.order]
        for code in codes:
            pad = padding(at, size_of(code[-1]))
            parts.append(f"{pad}x{code}" if pad else code)
            at += pad + size_of(code)
        return _struct("".join(parts))


_struct = cache(struct.Struct)
