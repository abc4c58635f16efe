"""CDR, the bytes of ROS messages, from the fields of their types.

A message is an encapsulation of four bytes and then its values, each aligned to its size.
We write little-endian, as all ROS does that is met with, and read both orders.
"""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING, Any, Final

from hmrsim_zenoh.ros2.codec import checked, decoders, encoders
from hmrsim_zenoh.ros2.codec.checked import CdrError
from hmrsim_zenoh.ros2.codec.layout import HEADER

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from hmrsim.interfaces.message import Message
    from hmrsim_zenoh.ros2.codec.rihs01 import Structure

__all__ = ["CdrError", "decoder", "encoder"]

_CDR_LE, _CDR_BE = b"\0\1", b"\0\0"

MAX_BYTES: Final = 4 << 20
"""Longer messages are not read: their values could take sixty times their room."""

_MAX_CHECKED: Final = 64 << 10
"""Longer messages are read quickly or not at all: `careful` takes seconds for a megabyte."""

_ANYTHING: Final = (struct.error, ValueError, TypeError, LookupError, AttributeError, OverflowError)
"""What the code of `encoders` and `decoders` can raise; `careful` finds out what is behind it, if anything is."""


def encoder(described: Structure) -> Callable[[Message | Mapping[str, Any]], bytes]:
    """Return what makes bytes of a message, or of its plain values; it raises `CdrError` if it can't."""
    quick = encoders.encoder(described)

    def encode(values: Message | Mapping[str, Any]) -> bytes:
        try:
            return quick(values)
        except _ANYTHING:
            return checked.write(described, values)

    return encode


def decoder(described: Structure) -> Callable[[bytes], dict[str, Any]]:
    """Return what makes plain values of a message's bytes; it raises `CdrError` if it can't.

    What comes after the message is not looked at, as ROS doesn't, either.
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
        return _careful(described, data)

    return decode


def _careful(described: Structure, data: bytes) -> dict[str, Any]:
    if len(data) < HEADER:
        raise CdrError(f"{described.name}: {len(data)} bytes are no CDR; it begins with an encapsulation of {HEADER}")
    if data[:2] not in (_CDR_LE, _CDR_BE):
        raise CdrError(f"{described.name}: encapsulation {data[:2].hex()} is not plain CDR, which is 0001 or 0000")
    if len(data) > MAX_BYTES:
        raise CdrError(f"{described.name}: {len(data)} bytes are more than the {MAX_BYTES} that are read at once")
    if len(data) > _MAX_CHECKED:
        raise CdrError(f"{described.name}: {len(data)} bytes, broken or big-endian, are too many to find out where")
    return checked.read(described, data, "<" if data[:2] == _CDR_LE else ">")
