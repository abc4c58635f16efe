"""Encoding of messages as CDR by generated functions, one for each type: a hundred times as fast as field by field.

Messages are written in little-endian, as in all common ROS systems.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from typing import TYPE_CHECKING, Any, Final

from hmrsim_zenoh.ros2.codec.layout import FORMATS, HEADER, CdrError, Code, Leaf, leaves, size_of
from hmrsim_zenoh.ros2.codec.structures import Field, Kind, Structure

if TYPE_CHECKING:
    from hmrsim.interfaces.message import Message

_ENCAPSULATION: Final = b"\0\1\0\0"
"""The encapsulation of a message in little-endian."""

_NAMES: Final = {
    "pack": struct.pack,
    "zeros": [bytes(n) for n in range(8)],
    "lengths": [struct.Struct(f"<{n}xI").pack for n in range(4)],
}

_ERRORS: Final = (struct.error, ValueError, TypeError, LookupError, AttributeError, OverflowError)
"""The exceptions of a generated function for a value that does not fit."""

_Write = Callable[[Any, Callable[[bytes], None], int], int]


@cache
def encoder(described: Structure) -> Callable[[Message | Mapping[str, Any]], bytes]:
    """Return a function that encodes a message or its plain values; it raises `CdrError`."""
    write = _writer(described, HEADER)

    def encode(values: Message | Mapping[str, Any]) -> bytes:
        parts = [_ENCAPSULATION]
        try:
            write(values, parts.append, HEADER)
        except _ERRORS as error:
            _check(described, values, f"{described.name}: ")
            raise CdrError(f"{described.name}: {error}") from None
        return b"".join(parts)

    return encode


@cache
def _writer(described: Structure, start: int | None = None) -> _Write:
    """Return a function that outputs the parts of a message and returns its end; its last argument is the offset.

    Args:
        described: The message's type.
        start: The fixed offset of the message; None if it varies.
    """
    code = _Code(start)
    for leaf in leaves(described):
        code.add(leaf)
    return code.finish(described)


class _Code(Code):
    def __init__(self, start: int | None) -> None:
        super().__init__(_NAMES, start, "<")
        self._opened: dict[tuple[str, ...], str] = {}
        self._codes: list[str] = []
        self._arguments: list[str] = []

    def finish(self, described: Structure) -> _Write:
        """Return the generated function."""
        self._flush()
        self.lines.append("return pos")
        write: _Write = self.function("def write(m, out, pos):", described)
        return write

    def add(self, leaf: Leaf) -> None:
        """Generate code that writes the next leaf."""
        field, value = leaf.field, self._value(leaf)
        if field.kind is Kind.SINGLE:
            self._single(field, value)
        elif field.kind is Kind.ARRAY and field.primitive in FORMATS:
            self._numbers(field, value)
        else:
            self._list(field, value)

    def _value(self, leaf: Leaf) -> str:
        """Return an expression for a leaf's value; a literal if our message lacks it."""
        if leaf.path is None:
            if leaf.field.kind is Kind.SINGLE:
                return '""' if leaf.field.primitive == "string" else "0"
            return f"(0,) * {leaf.field.capacity}" if leaf.field.kind is Kind.ARRAY else "()"
        *outer, name = leaf.path
        return f"{self._container(tuple(outer))}[{name!r}]"

    def _container(self, path: tuple[str, ...]) -> str:
        """Return the name of the dict of a nested message."""
        if path not in self._opened:
            got = f"{self._container(path[:-1])}[{path[-1]!r}]" if path else "m"
            name = self._opened[path] = f"d{len(self._opened)}"
            self.lines += [
                f"{name} = {got}",
                f"if type({name}) is not dict: {name} = getattr({name}, '__dict__', {name})",
            ]
        return self._opened[path]

    def _name(self, value: str) -> str:
        name = f"v{len(self.lines)}"
        self.lines.append(f"{name} = {value}")
        return name

    def _number(self, code: str, *arguments: str) -> None:
        self._codes.append(code)
        self._arguments += arguments

    def _single(self, field: Field, value: str) -> None:
        if field.primitive != "string":
            self._number(FORMATS[field.primitive], value)
            return
        text = self._name(f"{value}.encode()")
        self._number("I", f"len({text}) + 1")
        self._flush()
        self.lines += [f"out({text})", f"pos += len({text})"]
        self.at = None
        self._number("x")

    def _numbers(self, field: Field, value: str) -> None:
        code = FORMATS[field.primitive]
        numbers = self._name(value)
        self.lines.append(f"if len({numbers}) != {field.capacity}: raise ValueError")
        if code == "B":
            self._number(f"{field.capacity}s", f"bytes({numbers})")
        else:
            self._number(f"{field.capacity}{code}", f"*{numbers}")

    def _list(self, field: Field, value: str) -> None:
        items = self._name(value)
        if field.kind is Kind.ARRAY:
            self.lines.append(f"if len({items}) != {field.capacity}: raise ValueError")
        else:
            self._number("I", f"len({items})")
        if field.kind is Kind.BOUNDED:
            self.lines.append(f"if len({items}) > {field.capacity}: raise ValueError")
        self._flush()
        self.at = None
        if field.nested is not None:
            write = f"write{len(self.names)}"
            self.names[write] = _writer(field.nested)
            self.lines.append(f"for item in {items}: pos = {write}(item, out, pos)")
        elif field.primitive == "string":
            self._texts(items)
        else:
            self._block(FORMATS[field.primitive], items)

    def _texts(self, items: str) -> None:
        self.lines += [
            f"for text in {items}:",
            "    text = text.encode() + b'\\0'",
            "    pad = -pos & 3",
            "    out(lengths[pad](len(text)))",
            "    out(text)",
            "    pos += pad + 4 + len(text)",
        ]

    def _block(self, code: str, items: str) -> None:
        size = size_of(code)
        block = f"bytes({items})" if code == "B" else f"pack(f'<{{len({items})}}{code}', *{items})"
        if code == "b":
            # A map has millions of cells.
            block = f"{items} if type({items}) is bytes else {block}"
        self.lines += [
            f"if len({items}):",
            f"    pad = {HEADER} - pos & {size - 1}",
            "    if pad: out(zeros[pad])",
            f"    out({block})",
            f"    pos += pad + {size} * len({items})",
        ]

    def _flush(self) -> None:
        """Generate code that writes the pending numbers."""
        if self._codes:
            pack, advance = self.run(self._codes, lambda packed: packed.pack)
            self.lines += [f"out({pack}({', '.join(self._arguments)}))", advance]
            self._codes, self._arguments = [], []


def _check(described: Structure, values: object, place: str) -> None:
    """Find the value that does not fit, after a generated function has failed.

    Raises:
        CdrError: A value is missing or does not fit.
    """
    for field in described.fields:
        if field.path is None:
            continue
        name = f"{place}{field.name}"
        value = _value(field, values, name)
        if field.kind is Kind.SINGLE:
            _check_single(field, value, name)
            continue
        if not isinstance(value, Sequence) or isinstance(value, str):
            raise CdrError(f"{name}: {value!r} is not a list")
        if field.kind is Kind.ARRAY and len(value) != field.capacity:
            raise CdrError(f"{name}: {len(value)} items; exactly {field.capacity} are required")
        if field.kind is Kind.BOUNDED and len(value) > field.capacity:
            raise CdrError(f"{name}: {len(value)} items; at most {field.capacity} are allowed")
        for i, item in enumerate(value):
            _check_single(field, item, f"{name}[{i}]")


def _check_single(field: Field, value: object, name: str) -> None:
    if field.nested is not None:
        _check(field.nested, value, f"{name}.")
    elif field.primitive == "string":
        if not isinstance(value, str):
            raise CdrError(f"{name}: {value!r} is not a string")
        try:
            value.encode()
        except UnicodeEncodeError as error:
            raise CdrError(f"{name}: {value!r} has no UTF-8: {error.reason}") from None
    else:
        try:
            struct.pack(f"<{FORMATS[field.primitive]}", value)
        except (struct.error, OverflowError):
            raise CdrError(f"{name}: {value!r} is not a valid {field.primitive}") from None


def _value(field: Field, values: object, name: str) -> Any:
    for part in field.path or ():
        values = getattr(values, "__dict__", values)
        if not isinstance(values, Mapping):
            raise CdrError(f"{name}: {values!r} is not a message")
        if part not in values:
            raise CdrError(f"{name}: the value of {part!r} is missing")
        values = values[part]
    return values
