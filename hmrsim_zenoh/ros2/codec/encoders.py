"""Generated functions that encode messages as CDR, one for each type: a hundred times as fast as field by field.

They accept messages and dicts only, and their exceptions say little; `checked` finds the error.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from functools import cache
from typing import Any

from hmrsim_zenoh.ros2.codec.codegen import Code
from hmrsim_zenoh.ros2.codec.layout import FORMATS, HEADER, LITTLE_ENDIAN, Leaf, leaves, size_of
from hmrsim_zenoh.ros2.codec.structures import Field, Kind, Structure

_PRELUDE = {
    "pack": struct.pack,
    "zeros": [bytes(n) for n in range(8)],
    "lengths": [struct.Struct(f"<{n}xI").pack for n in range(4)],
}


@cache
def encoder(described: Structure) -> Callable[[Any], bytes]:
    """Return a function that encodes a message; for invalid values it may raise anything."""
    write = _writer(described, HEADER)

    def encode(values: Any) -> bytes:
        parts = [LITTLE_ENDIAN]
        write(values, parts.append, HEADER)
        return b"".join(parts)

    return encode


@cache
def _writer(described: Structure, start: int | None = None) -> Callable[[Any, Callable[[bytes], None], int], int]:
    """Return a function that outputs the parts of a message and returns its end; its last argument is the offset.

    Args:
        described: The message's type.
        start: The fixed offset of the message; None if it varies.
    """
    code = _Code(start)
    for leaf in leaves(described):
        code.add(leaf)
    return code.function(described.name)


class _Code(Code):
    def __init__(self, start: int | None) -> None:
        super().__init__(_PRELUDE, start)
        self._opened: dict[tuple[str, ...], str] = {}
        self._codes: list[str] = []
        self._arguments: list[str] = []

    def function(self, name: str) -> Callable[[Any, Callable[[bytes], None], int], int]:
        """Return the generated function."""
        self._flush()
        body = "\n    ".join([*self.lines, "return pos"])
        source = f"def write(m, out, pos):\n    {body}\n"
        exec(compile(source, f"<writer of {name}>", "exec"), self.names)  # noqa: S102 - made of nothing but field names
        written: Callable[[Any, Callable[[bytes], None], int], int] = self.names["write"]
        return written

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
            self.lines += [f"{name} = {got}", f"if type({name}) is not dict: {name} = {name}.__dict__"]
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
        self.lines += [
            f"if len({items}):",
            f"    pad = {HEADER} - pos & {size - 1}",
            "    if pad: out(zeros[pad])",
            f"    out({block})",
            f"    pos += pad + {size} * len({items})",
        ]

    def _flush(self) -> None:
        """Generate code that writes the pending numbers."""
        if not self._codes:
            return
        arguments = ", ".join(self._arguments)
        self.run(self._codes, lambda packed: packed.pack, lambda pack: f"out({pack}({arguments}))")
        self._codes, self._arguments = [], []
