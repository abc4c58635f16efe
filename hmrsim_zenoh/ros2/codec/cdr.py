"""CDR, the serialisation of ROS messages.

A message is an encapsulation of four bytes and then its values, each aligned to its size.
Messages are written in little-endian, as in all common ROS systems, and read in both byte orders.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Final

from hmrsim_zenoh.ros2.codec import checked, decoders, encoders
from hmrsim_zenoh.ros2.codec.checked import CdrError
from hmrsim_zenoh.ros2.codec.layout import HEADER

if TYPE_CHECKING:
    from hmrsim.interfaces.message import Message
    from hmrsim_zenoh.ros2.codec.structures import Structure

__all__ = ["CdrError", "decoder", "encoder"]

_CDR_LE, _CDR_BE = b"\0\1", b"\0\0"

MAX_BYTES: Final = 4 << 20
"""The largest message that is read, in bytes: as Python values it may take sixty times that."""

_MAX_CHECKED: Final = 64 << 10
"""The largest message in bytes that `checked` reads, which takes seconds for a megabyte."""

_ANYTHING: Final = (struct.error, ValueError, TypeError, LookupError, AttributeError, OverflowError)
"""The exceptions of the code of `encoders` and `decoders`; `checked` then finds the error, if there is one."""


def encoder(described: Structure) -> Callable[[Message | Mapping[str, Any]], bytes]:
    """Return a function that encodes a message or its plain values; it raises `CdrError`."""
    quick = encoders.encoder(described)

    def encode(values: Message | Mapping[str, Any]) -> bytes:
        try:
            return quick(values)
        except _ANYTHING:
            return checked.write(described, values)

    return encode


def decoder(described: Structure) -> Callable[[bytes], dict[str, Any]]:
    """Return a function that decodes a message to plain values; it raises `CdrError`.

    Bytes after the message are ignored, as in ROS.
    """
    quick = decoders.decoder(described)

    def decode(data: bytes) -> dict[str, Any]:
        if data[:2] == _CDR_LE and len(data) <= MAX_BYTES:
            try:
                return quick(data)
            except CdrError:
                raise
            except _ANYTHING:
                pass
        return _checked(described, data)

    return decode


def _checked(described: Structure, data: bytes) -> dict[str, Any]:
    if len(data) < HEADER:
        raise CdrError(f"{described.name}: {len(data)} bytes are not CDR, which has an encapsulation of {HEADER} bytes")
    if data[:2] not in (_CDR_LE, _CDR_BE):
        raise CdrError(f"{described.name}: encapsulation {data[:2].hex()} is not plain CDR, which is 0001 or 0000")
    if len(data) > MAX_BYTES:
        raise CdrError(f"{described.name}: {len(data)} bytes; at most {MAX_BYTES} are read")
    if len(data) > _MAX_CHECKED:
        raise CdrError(
            f"{described.name}: an invalid or big-endian message of {len(data)} bytes; up to {_MAX_CHECKED} are read"
        )
    return checked.read(described, data, "<" if data[:2] == _CDR_LE else ">")
