"""CDR value by value: slow, in either byte order, and with errors that name the place and the mistake.

It is the fallback of `encoders` and `decoders` for invalid and for unusual messages.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final

from hmrsim.interfaces.message import Message
from hmrsim_zenoh.ros2.codec.layout import (
    FORMATS,
    HEADER,
    LITTLE_ENDIAN,
    MAX_ITEMS,
    TOO_MANY,
    least_size,
    padding,
    size_of,
    weight,
)
from hmrsim_zenoh.ros2.codec.structures import PADDING, Field, Kind, Structure

_NOTHING: Final = object()
"""The value of a field that our message lacks: zero, or empty."""


class CdrError(ValueError):
    """Bytes are not a message of their type, or a value does not fit into its field."""


class _Flaw(Exception):
    """An error on its way up to the callers, which add the names of the enclosing fields."""

    place = ""


def read(described: Structure, data: bytes, order: str) -> dict[str, Any]:
    """Return the plain values of a serialised message in the byte *order* ``<`` or ``>``.

    Raises:
        CdrError: The message is too short or has an invalid value.
    """
    reader = _Reader(data, order)
    try:
        return reader.structure(described)
    except _Flaw as flaw:
        raise CdrError(f"{described.name}: {flaw.place}: {flaw}, at byte {reader.at} of {len(data)}") from None


def write(described: Structure, values: Message | Mapping[str, Any]) -> bytes:
    """Return a serialised message.

    Raises:
        CdrError: A value is missing or does not fit.
    """
    writer = _Writer()
    try:
        writer.structure(described, values)
    except _Flaw as flaw:
        place = f" {flaw.place}:" if flaw.place else ""
        raise CdrError(f"{described.name}:{place} {flaw}") from None
    return bytes(writer.data)


def _within(name: str, act: Callable[..., Any], *args: object) -> Any:
    try:
        return act(*args)
    except _Flaw as flaw:
        dot = "." if flaw.place and not flaw.place.startswith("[") else ""
        flaw.place = f"{name}{dot}{flaw.place}"
        raise


class _Reader:
    def __init__(self, data: bytes, order: str) -> None:
        self._data = data
        self._order = order
        self._left = MAX_ITEMS
        self.at = HEADER

    def structure(self, described: Structure) -> dict[str, Any]:
        values: dict[str, Any] = {}
        for field in described.fields:
            if field is PADDING:
                # Implementations with empty structures omit it.
                self.at = min(self.at + 1, len(self._data))
                continue
            value = _within(field.name, self._field, field)
            if field.path is not None:
                _put(values, field.path, value)
        return values

    def _field(self, field: Field) -> Any:
        if field.kind is Kind.SINGLE:
            return self._single(field)
        count = field.capacity if field.kind is Kind.ARRAY else self._count(field)
        self._left -= count * weight(field)
        if self._left < 0:
            raise _Flaw(TOO_MANY)
        return [_within(f"[{i}]", self._single, field) for i in range(count)]

    def _count(self, field: Field) -> int:
        count: int = self._number("uint32")
        left = len(self._data) - self.at
        if field.kind is Kind.BOUNDED and count > field.capacity:
            raise _Flaw(f"{count} items; at most {field.capacity} are allowed")
        if count * least_size(field) > left:
            raise _Flaw(f"{count} items do not fit in the {left} remaining bytes")
        return count

    def _single(self, field: Field) -> Any:
        if field.nested is not None:
            return self.structure(field.nested)
        if field.primitive == "string":
            return self._text()
        value = self._number(field.primitive)
        if field.primitive == "boolean" and value > 1:
            raise _Flaw(f"{value} is neither true (1) nor false (0)")
        return bool(value) if field.primitive == "boolean" else value

    def _number(self, primitive: str) -> Any:
        code = FORMATS[primitive].replace("?", "B")
        start = self.at + padding(self.at, size_of(code))
        end = start + size_of(code)
        if end > len(self._data):
            raise _Flaw("the message ends within the value")
        self.at = end
        return struct.unpack_from(self._order + code, self._data, start)[0]

    def _text(self) -> str:
        length = self._number("uint32")
        left = len(self._data) - self.at
        if length > left:
            raise _Flaw(f"a string of {length} bytes does not fit in the {left} remaining bytes")
        start, self.at = self.at, self.at + length
        try:
            # ROS accepts strings without the terminating zero, and zero bytes as the empty string.
            return self._data[start : self.at].removesuffix(b"\0").decode()
        except UnicodeDecodeError as error:
            raise _Flaw(f"invalid UTF-8: {error.reason}") from None


class _Writer:
    def __init__(self) -> None:
        self.data = bytearray(LITTLE_ENDIAN)

    def structure(self, described: Structure, values: object) -> None:
        for field in described.fields:
            _within(field.name, self._field, field, values)

    def _field(self, field: Field, values: object) -> None:
        value = _value(field, values)
        if field.kind is Kind.SINGLE:
            self._single(field, value)
            return
        if value is _NOTHING:
            value = [_NOTHING] * (field.capacity if field.kind is Kind.ARRAY else 0)
        if not isinstance(value, Sequence) or isinstance(value, str):
            raise _Flaw(f"{value!r} is not a list")
        if field.kind is Kind.ARRAY and len(value) != field.capacity:
            raise _Flaw(f"{len(value)} items; exactly {field.capacity} are required")
        if field.kind is Kind.BOUNDED and len(value) > field.capacity:
            raise _Flaw(f"{len(value)} items; at most {field.capacity} are allowed")
        if field.kind is not Kind.ARRAY:
            self._number("uint32", len(value))
        for i, item in enumerate(value):
            _within(f"[{i}]", self._single, field, item)

    def _single(self, field: Field, value: object) -> None:
        if field.nested is not None:
            self.structure(field.nested, value)
        elif field.primitive == "string":
            self._text("" if value is _NOTHING else value)
        else:
            self._number(field.primitive, 0 if value is _NOTHING else value)

    def _number(self, primitive: str, value: object) -> None:
        code = FORMATS[primitive]
        self.data += bytes(padding(len(self.data), size_of(code)))
        try:
            self.data += struct.pack(f"<{code}", value)
        except (struct.error, OverflowError):
            raise _Flaw(f"{value!r} is not a valid {primitive}") from None

    def _text(self, value: object) -> None:
        if not isinstance(value, str):
            raise _Flaw(f"{value!r} is not a string")
        try:
            text = value.encode() + b"\0"
        except UnicodeEncodeError as error:
            raise _Flaw(f"{value!r} has no UTF-8: {error.reason}") from None
        self._number("uint32", len(text))
        self.data += text


def _put(values: dict[str, Any], path: tuple[str, ...], value: Any) -> None:
    if not path:
        values.update(value)
        return
    for name in path[:-1]:
        values = values.setdefault(name, {})
    values[path[-1]] = value


def _value(field: Field, values: object) -> Any:
    if field.path is None or values is _NOTHING:
        return _NOTHING
    for name in field.path:
        if isinstance(values, Message):
            values = values.__dict__
        if not isinstance(values, Mapping):
            raise _Flaw(f"{values!r} is not a message")
        if name not in values:
            raise _Flaw(f"the value of {name!r} is missing")
        values = values[name]
    return values
