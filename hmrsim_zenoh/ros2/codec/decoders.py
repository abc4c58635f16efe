"""Generated functions that decode messages from CDR, one for each type: the counterparts of `encoders`.

They read little-endian bytes, and their exceptions say little; `checked` finds the error.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from functools import cache
from typing import Any

from hmrsim_zenoh.ros2.codec.checked import CdrError
from hmrsim_zenoh.ros2.codec.codegen import Code
from hmrsim_zenoh.ros2.codec.layout import (
    FORMATS,
    HEADER,
    MAX_ITEMS,
    TOO_MANY,
    Leaf,
    containers,
    least_size,
    leaves,
    size_of,
    weight,
)
from hmrsim_zenoh.ros2.codec.structures import Field, Kind, Structure

_PRELUDE = {"unpack": struct.unpack_from, "flags": (False, True), "CdrError": CdrError}

_Read = Callable[[bytes, int, int, list[int]], tuple[dict[str, Any], int]]


@cache
def decoder(described: Structure) -> Callable[[bytes], dict[str, Any]]:
    """Return a function that decodes a message to plain values; for invalid bytes it may raise anything.

    It raises `CdrError` only for a message that is too costly to decode.
    """
    read = _reader(described, HEADER)
    return lambda data: read(data, HEADER, len(data), [MAX_ITEMS])[0]


@cache
def _reader(described: Structure, start: int | None = None) -> _Read:
    """Return a function that decodes a message and returns its values and its end.

    Its arguments are the bytes, the offset of the message, the end of the bytes, and a list with the number of items
    that may still follow.

    Args:
        described: The message's type.
        start: The fixed offset of the message; None if it varies.
    """
    code = _Code(described.name, start)
    for leaf in leaves(described):
        code.add(leaf)
    for path in containers(described):
        code.nest(path)
    return code.function()


class _Code(Code):
    def __init__(self, name: str, start: int | None) -> None:
        self._of = name
        super().__init__(_PRELUDE, start)
        self._count = 0
        self._codes: list[str] = []
        self._targets: list[str] = []
        self._checks: list[str] = []
        self._values: dict[str, Any] = {}

    def function(self) -> _Read:
        """Return the generated function."""
        self._flush()
        body = "\n    ".join([*self.lines, f"return {_literal(self._values)}, pos"])
        source = f"def read(data, pos, end, left):\n    {body}\n"
        exec(compile(source, f"<reader of {self._of}>", "exec"), self.names)  # noqa: S102 - made of nothing but field names
        read: _Read = self.names["read"]
        return read

    def nest(self, path: tuple[str, ...]) -> dict[str, Any]:
        """Return the dict of a nested message in the result; it exists even if it is empty."""
        within = self._values
        for name in path:
            within = within.setdefault(name, {})
        return within

    def add(self, leaf: Leaf) -> None:
        """Generate code that reads the next leaf."""
        field = leaf.field
        if field.kind is Kind.SINGLE:
            value = self._single(field)
        elif field.kind is Kind.ARRAY and field.primitive in FORMATS:
            value = self._numbers(field)
        else:
            value = self._list(field)
        if leaf.path is not None:
            *outer, name = leaf.path
            self.nest(tuple(outer))[name] = value
        elif field.primitive == "boolean":
            # A dropped value must still be a valid boolean, as in Fast-CDR.
            self._checks.append(value)

    def _name(self) -> str:
        self._count += 1
        return f"v{self._count}"

    def _number(self, code: str) -> str:
        name = self._name()
        self._codes.append(code)
        self._targets.append(name)
        return name

    def _single(self, field: Field) -> str:
        if field.primitive == "boolean":
            return f"flags[{self._number('B')}]"
        if field.primitive != "string":
            return self._number(FORMATS[field.primitive])
        length = self._number("I")
        self._flush()
        self.at = None
        text = self._name()
        self.lines += _text(length, text)
        return text

    def _numbers(self, field: Field) -> str:
        code = FORMATS[field.primitive]
        if code == "B":
            return f"list({self._number(f'{field.capacity}s')})"
        names = [self._name() for _ in range(field.capacity)]
        self._codes.append(f"{field.capacity}{code.replace('?', 'B')}")
        self._targets += names
        return f"[{', '.join(f'flags[{name}]' if code == '?' else name for name in names)}]"

    def _list(self, field: Field) -> str:
        count = str(field.capacity) if field.kind is Kind.ARRAY else self._number("I")
        self._flush()
        self.at = None
        items = self._name()
        if field.kind is Kind.BOUNDED:
            self.lines.append(f"if {count} > {field.capacity}: raise ValueError")
        if field.primitive in FORMATS:
            self.lines += _block(FORMATS[field.primitive], items, count)
            return items
        if field.nested is not None:
            read = f"read{len(self.names)}"
            self.names[read] = _reader(field.nested)
            item = [f"item, pos = {read}(data, pos, end, left)"]
        else:
            item = ["pos += -pos & 3", "(size,) = unpack('<I', data, pos)", "pos += 4", *_text("size", "item")]
        # Checked first, so that an invalid count allocates nothing.
        self.lines.append(f"if {count} * {least_size(field)} > end - pos: raise ValueError")
        self.lines += [
            f"left[0] -= {count} * {weight(field)}",
            f"if left[0] < 0: raise CdrError({f'{self._of}: {field.name}: {TOO_MANY}'!r})",
        ]
        self.lines += [f"{items} = []", f"for _ in range({count}):"]
        self.lines += [f"    {line}" for line in [*item, f"{items}.append(item)"]]
        return items

    def _flush(self) -> None:
        """Generate code that reads the pending numbers."""
        if self._codes:
            targets = f"({', '.join(self._targets)},)"
            self.run(self._codes, lambda packed: packed.unpack_from, lambda unpack: f"{targets} = {unpack}(data, pos)")
        self.lines += self._checks
        self._codes, self._targets, self._checks = [], [], []


def _text(length: str, target: str) -> list[str]:
    """Return lines that read a string; for length 0 the previous byte, which is zero, serves as the terminator."""
    return [
        f"pos += {length}",
        "if pos > end: raise ValueError",
        f"{target} = (data[pos - {length}:pos - 1] if not data[pos - 1] else data[pos - {length}:pos]).decode()",
    ]


def _block(code: str, items: str, count: str) -> list[str]:
    """Return lines that read a sequence of numbers."""
    size = size_of(code)
    read = {
        "B": "list(data[start:pos])",
        "?": "[flags[byte] for byte in data[start:pos]]",
    }.get(code, f"list(unpack(f'<{{{count}}}{code}', data, start))")
    return [
        f"{items} = []",
        f"if {count}:",
        f"    start = pos + ({HEADER} - pos & {size - 1})",
        f"    pos = start + {size} * {count}",
        "    if pos > end: raise ValueError",
        f"    {items} = {read}",
    ]


def _literal(values: Any) -> str:
    if isinstance(values, str):
        return values
    return f"{{{', '.join(f'{name!r}: {_literal(value)}' for name, value in values.items())}}}"
