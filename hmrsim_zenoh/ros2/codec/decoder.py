"""Decoding of messages from CDR by generated functions, one for each type and byte order.

An invalid message raises an exception somewhere in a generated function. The line at which it did so, and the values of
the variables there, give the field and the byte for the error message.
"""

from __future__ import annotations

import functools
import itertools
import struct
from collections.abc import Callable, Iterator, Mapping
from typing import Any, Final, NamedTuple

from hmrsim_zenoh.ros2.codec.layout import FORMATS, HEADER, CdrError, Code, Leaf, leaves, padding, size_of
from hmrsim_zenoh.ros2.codec.structures import PADDING, Field, Kind, Structure

_ORDERS: Final = {b"\0\1": "<", b"\0\0": ">"}
"""The byte orders by the first bytes of the encapsulation."""
_LITTLE_ENDIAN: Final = b"\0\1"

MAX_BYTES: Final = 4 << 20
"""The largest message that is read, in bytes: as Python values it may take sixty times that."""

MAX_ITEMS: Final = 10_000
"""The largest number of messages and strings in all lists of one message: each takes microseconds to check."""

_SOURCES: Final = "SOURCES"
"""The name of the table of fields by line, among the globals of a generated function."""
_FIRST_LINE: Final = 2
_BLOCK: Final = "start"
"""The variable with the start of the numbers of a list."""
_NO_FLAG: Final = "{} is neither true (1) nor false (0)"
_NAMES: Final = {
    "unpack": struct.unpack_from,
    "flags": (False, True),
    "flag": (False, True).__getitem__,
    "CdrError": CdrError,
}

_Read = Callable[[bytes, int, int, list[int]], tuple[dict[str, Any], int]]


@functools.cache
def decoder(described: Structure) -> Callable[[bytes], dict[str, Any]]:
    """Return a function that decodes a message to plain values; it raises `CdrError`.

    Bytes after the message are ignored, as in ROS.
    """
    little_endian = _reader(described, "<", HEADER)

    def decode(data: bytes) -> dict[str, Any]:
        size = len(data)
        read = little_endian
        if data[:2] != _LITTLE_ENDIAN or not HEADER <= size <= MAX_BYTES:
            read = _reader(described, _order_of(described, data), HEADER)
        try:
            return read(data, HEADER, size, [MAX_ITEMS])[0]
        except (struct.error, ValueError, IndexError) as error:
            raise _located(described, data, error) from None

    return decode


def _order_of(described: Structure, data: bytes) -> str:
    """Return the byte order of a message.

    Raises:
        CdrError: The message is too large, or its encapsulation is not that of plain CDR.
    """
    if len(data) < HEADER:
        raise CdrError(f"{described.name}: {len(data)} bytes are not CDR, which has an encapsulation of {HEADER} bytes")
    if data[:2] not in _ORDERS:
        raise CdrError(f"{described.name}: encapsulation {data[:2].hex()} is not plain CDR, which is 0001 or 0000")
    if len(data) > MAX_BYTES:
        raise CdrError(f"{described.name}: {len(data)} bytes; at most {MAX_BYTES} are read")
    return _ORDERS[data[:2]]


@functools.cache
def _reader(described: Structure, order: str, start: int | None = None) -> _Read:
    """Return a function that decodes a message and returns its values and its end.

    Its arguments are the bytes, the offset of the message, the end of the bytes, and a list with the number of items
    that may still follow.

    Args:
        described: The message's type.
        order: The byte order, ``<`` or ``>``.
        start: The fixed offset of the message; None if it varies.
    """
    code = _Code(start, order)
    for leaf in leaves(described):
        code.add(leaf)
    for path in _containers(described):
        code.nest(path)
    return code.finish(described)


class _Source(NamedTuple):
    """The fields that a generated line reads.

    Attributes:
        names: The fields in order; only the last one can be at fault unless the message ends within another.
        codes: Their formats, for a line that reads numbers from ``pos`` on.
        items: The name of the list that the line adds an item to; empty if there is none.
        flags: The variable whose value has to be 0 or 1, or `_BLOCK` for a list of such bytes.
    """

    names: tuple[str, ...]
    codes: tuple[str, ...] = ()
    items: str = ""
    flags: str = ""


class _Code(Code):
    def __init__(self, start: int | None, order: str) -> None:
        super().__init__(_NAMES, start, order)
        self._sources: dict[int, _Source] = {}
        self._count = 0
        # The pending numbers: their fields, formats and variables, and which of them are booleans.
        self._pending: list[tuple[str, str]] = []
        self._targets: list[str] = []
        self._booleans: list[tuple[int, str]] = []
        self._values: dict[str, Any] = {}

    def finish(self, described: Structure) -> _Read:
        """Return the generated function."""
        self._flush()
        self.lines.append(f"return {_literal(self._values)}, pos")
        self.names[_SOURCES] = self._sources
        read: _Read = self.function("def read(data, pos, end, left):", described)
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
        if field is PADDING:
            self._skip_padding()
            return
        if field.kind is Kind.SINGLE:
            value = self._single(leaf)
        elif field.kind is Kind.ARRAY and field.primitive in FORMATS:
            value = self._numbers(leaf)
        else:
            value = self._list(leaf)
        if leaf.path is not None:
            *outer, name = leaf.path
            self.nest(tuple(outer))[name] = value

    def _skip_padding(self) -> None:
        """Generate code that skips the byte of an empty type; at the end of a message it may be missing."""
        self._flush()
        self.lines.append("pos += 1")
        if self.at is not None:
            self.at += 1

    def _emit(self, source: _Source, *lines: str) -> None:
        for line in lines:
            self._sources[_FIRST_LINE + len(self.lines)] = source
            self.lines.append(line)

    def _name(self) -> str:
        self._count += 1
        return f"v{self._count}"

    def _number(self, name: str, code: str) -> str:
        target = self._name()
        if code[-1] == "?":
            code = f"{code[:-1]}B"
            self._booleans.append((len(self._pending), target))
        self._pending.append((name, code))
        self._targets.append(target)
        return target

    def _single(self, leaf: Leaf) -> str:
        if leaf.field.primitive != "string":
            return self._number(leaf.name, FORMATS[leaf.field.primitive])
        length = self._number(leaf.name, "I")
        self._flush()
        self.at = None
        text = self._name()
        self._emit(_Source((leaf.name,)), *_text(length, text))
        return text

    def _numbers(self, leaf: Leaf) -> str:
        code, count = FORMATS[leaf.field.primitive], leaf.field.capacity
        if code == "B":
            return f"list({self._number(leaf.name, f'{count}s')})"
        return f"[{', '.join(self._number(f'{leaf.name}[{i}]', code) for i in range(count))}]"

    def _list(self, leaf: Leaf) -> str:
        field = leaf.field
        count = str(field.capacity) if field.kind is Kind.ARRAY else self._number(leaf.name, "I")
        self._flush()
        self.at = None
        items = self._name()
        source = _Source((leaf.name,))
        if field.kind is Kind.BOUNDED:
            problem = f"{{{count}}} items; at most {field.capacity} are allowed"
            self._emit(source, f"if {count} > {field.capacity}: raise CdrError(f{problem!r})")
        # Checked first, so that an invalid count allocates nothing.
        problem = f"{{{count}}} items do not fit in the {{end - pos}} remaining bytes"
        self._emit(source, f"if {count} * {_least_size(field)} > end - pos: raise CdrError(f{problem!r})")
        if field.primitive in FORMATS:
            self._block(leaf.name, FORMATS[field.primitive], items, count)
            return items
        if field.nested is not None:
            read = f"read{len(self.names)}"
            self.names[read] = _reader(field.nested, self.order)
            item = [f"item, pos = {read}(data, pos, end, left)"]
        else:
            item = [
                "pos += -pos & 3",
                f"(size,) = unpack('{self.order}I', data, pos)",
                "pos += 4",
                *_text("size", "item"),
            ]
        problem = f"more than {MAX_ITEMS} messages and strings in the lists of one message"
        self._emit(source, f"left[0] -= {count} * {_weight(field)}", f"if left[0] < 0: raise CdrError({problem!r})")
        self._emit(source, f"{items} = []", f"for _ in range({count}):")
        each = _Source((leaf.name,), ("I",), items=items)
        self._emit(each, *(f"    {line}" for line in [*item, f"{items}.append(item)"]))
        return items

    def _block(self, name: str, code: str, items: str, count: str) -> None:
        """Generate code that reads a sequence of numbers."""
        size = size_of(code)
        read = {"B": "list(data[start:pos])", "?": "list(map(flag, data[start:pos]))"}.get(
            code, f"list(unpack(f'{self.order}{{{count}}}{code}', data, start))"
        )
        self._emit(
            _Source((name,), flags=_BLOCK),
            f"{items} = []",
            f"if {count}:",
            f"    start = pos + ({HEADER} - pos & {size - 1})",
            f"    pos = start + {size} * {count}",
            "    if pos > end: raise CdrError('the message ends within the value')",
            f"    {items} = {read}",
        )

    def _flush(self) -> None:
        """Generate code that reads the pending numbers."""
        if not self._pending:
            return
        names, codes = zip(*self._pending, strict=True)
        unpack, advance = self.run(codes, lambda packed: packed.unpack_from)
        self._emit(_Source(names, codes), f"({', '.join(self._targets)},) = {unpack}(data, pos)")
        for i, target in self._booleans:
            # Checked even if the value is dropped, as in Fast-CDR.
            source = _Source(names[: i + 1], codes[: i + 1], flags=target)
            self._emit(source, f"{target} = flags[{target}]")
        self.lines.append(advance)
        self._pending, self._targets, self._booleans = [], [], []


def _text(length: str, target: str) -> list[str]:
    """Return lines that read a string; for length 0 the previous byte, which is zero, serves as the terminator.

    ROS accepts strings without the terminating zero, and zero bytes as the empty string.
    """
    problem = f"a string of {{{length}}} bytes does not fit in the {{end - pos}} remaining bytes"
    return [
        f"if {length} > end - pos: raise CdrError(f{problem!r})",
        f"pos += {length}",
        f"{target} = (data[pos - {length}:pos - 1] if not data[pos - 1] else data[pos - {length}:pos]).decode()",
    ]


def _literal(values: Any) -> str:
    if isinstance(values, str):
        return values
    return f"{{{', '.join(f'{name!r}: {_literal(value)}' for name, value in values.items())}}}"


def _containers(described: Structure) -> Iterator[tuple[str, ...]]:
    """Yield the path of each nested message that is not in a list, the outer ones first."""
    for field in described.fields:
        if field.path is not None and field.nested is not None and field.kind is Kind.SINGLE:
            if field.path:
                yield field.path
            yield from (field.path + path for path in _containers(field.nested))


@functools.cache
def _weight(field: Field) -> int:
    """Return the weight of one list item towards `MAX_ITEMS`: the number of messages in it; 0 for a number."""
    if field.nested is not None:
        return 1 + sum(1 for _ in _containers(field.nested))
    return 1 if field.primitive == "string" else 0


@functools.cache
def _least_size(field: Field) -> int:
    """Return the smallest size of one item of a field in bytes; at least 1, as no ROS type is empty."""
    if field.nested is None:
        return size_of("I" if field.primitive == "string" else FORMATS[field.primitive])
    size = 0
    for leaf in leaves(field.nested):
        of_list = leaf.field.kind in (Kind.BOUNDED, Kind.UNBOUNDED)
        size += size_of("I") if of_list else _least_size(leaf.field) * (leaf.field.capacity or 1)
    return size


def _located(described: Structure, data: bytes, error: Exception) -> CdrError:
    """Return the error about an invalid message, with the field and the byte at which reading failed."""
    calls: list[tuple[_Source, Mapping[str, Any]]] = []
    trace = error.__traceback__
    while trace is not None:
        source = trace.tb_frame.f_globals.get(_SOURCES, {}).get(trace.tb_lineno)
        if source is not None:
            calls.append((source, trace.tb_frame.f_locals))
        trace = trace.tb_next
    *outer, (source, values) = calls
    name, text, at = _problem(source, data, error, values)
    places = [(one.names[0], one, its) for one, its in outer] + [(name, source, values)]
    place = ".".join(f"{name}[{len(its[one.items])}]" if one.items else name for name, one, its in places)
    return CdrError(f"{described.name}: {place}: {text}, at byte {at} of {len(data)}")


def _problem(source: _Source, data: bytes, error: Exception, values: Mapping[str, Any]) -> tuple[str, str, int]:
    """Return the field at which a line failed, the problem, and the byte."""
    name, at = source.names[-1], values["pos"]
    if isinstance(error, struct.error):
        starts = [*itertools.accumulate(source.codes, _after, initial=at)]
        i = next(i for i, end in enumerate(starts[1:]) if end > len(data))
        return source.names[i], "the message ends within the value", starts[i]
    if isinstance(error, IndexError) and source.flags == _BLOCK:
        start = values[_BLOCK]
        i, value = next((i, byte) for i, byte in enumerate(data[start:]) if byte > 1)
        return f"{name}[{i}]", _NO_FLAG.format(value), start + i + 1
    if isinstance(error, IndexError) and source.flags:
        return name, _NO_FLAG.format(values[source.flags]), functools.reduce(_after, source.codes, at)
    return name, f"invalid UTF-8: {error.reason}" if isinstance(error, UnicodeDecodeError) else str(error), at


def _after(at: int, code: str) -> int:
    return at + padding(at, size_of(code[-1])) + size_of(code)
