"""A decoder of CDR that reads value by value, against which tests check the generated one."""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING, Any

from hmrsim_zenoh.ros2.codec.structures import PADDING, Field, Kind, Structure

if TYPE_CHECKING:
    from collections.abc import Mapping

FORMATS: Mapping[str, str] = dict(
    zip(
        (
            "int8",
            "uint8",
            "byte",
            "boolean",
            "int16",
            "uint16",
            "int32",
            "uint32",
            "int64",
            "uint64",
            "float",
            "double",
        ),
        "bBBBhHiIqQfd",
        strict=True,
    )
)


class Reader:
    """Reads one message value by value."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._at = 4

    def structure(self, described: Structure) -> dict[str, Any]:
        """Return the plain values of a message; raise a `ValueError` if it is invalid."""
        values: dict[str, Any] = {}
        for field in described.fields:
            if field is PADDING:
                self._at += 1
                continue
            value = self._field(field)
            if field.path == ():
                values.update(value)
            elif field.path is not None:
                *outer, name = field.path
                within = values
                for each in outer:
                    within = within.setdefault(each, {})
                within[name] = value
        return values

    def _field(self, field: Field) -> Any:
        if field.kind is Kind.SINGLE:
            return self._single(field)
        count = field.capacity if field.kind is Kind.ARRAY else self._number("I")
        if count > field.capacity and field.kind is Kind.BOUNDED:
            raise ValueError
        values = []
        for _ in range(count):
            values.append(self._single(field))
            if field.kind is not Kind.ARRAY and self._at > len(self._data):
                raise ValueError
        return values

    def _single(self, field: Field) -> Any:
        if field.nested is not None:
            return self.structure(field.nested)
        if field.primitive == "string":
            length = self._number("I")
            start, self._at = self._at, self._at + length
            if self._at > len(self._data):
                raise ValueError
            return self._data[start : self._at].removesuffix(b"\0").decode()
        value = self._number(FORMATS[field.primitive])
        if field.primitive != "boolean":
            return value
        if value > 1:
            raise ValueError
        return bool(value)

    def _number(self, code: str) -> Any:
        size = struct.calcsize(code)
        start = self._at + -(self._at - 4) % size
        self._at = start + size
        if self._at > len(self._data):
            raise ValueError
        return struct.unpack_from(f"<{code}", self._data, start)[0]


def read(described: Structure, data: bytes) -> dict[str, Any]:
    """Return the plain values of a message in little-endian; raise a `ValueError` if it is invalid."""
    return Reader(data).structure(described)
