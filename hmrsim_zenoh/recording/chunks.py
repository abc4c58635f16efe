"""Reading of MCAP files record by record, without trusting the sizes that they claim."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from io import BytesIO
from typing import IO, TYPE_CHECKING, Final, NamedTuple

import lz4.frame  # type: ignore[import-untyped]  # has no stubs
import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Schema
from mcap.stream_reader import StreamReader
from mcap.writer import MCAP0_MAGIC

if TYPE_CHECKING:
    from mcap.records import McapRecord

MAX_UNPACKED: Final = 64 << 20
"""The largest unpacked chunk in bytes; hmrsim's chunks have 1 MiB and at most one more message."""

_FREE_BYTES: Final = 16 << 20
_MAX_RATIO: Final = 100
"""Unpacked bytes of a file are at most so many more than *_FREE_BYTES*; those of an idle world are 21 times as many."""

_FREE_MESSAGES: Final = 100_000
_BYTES_PER_MESSAGE: Final = 2
"""Messages of a file are at most so many more than *_FREE_MESSAGES*; those of an idle world have 30 bytes each."""

BROKEN: Final = (
    McapError, struct.error, ValueError, LookupError, OverflowError, EOFError, MemoryError, zstandard.ZstdError,
    RuntimeError,
)  # fmt: skip
"""The exceptions of reading invalid data, such as a claimed string of 4 GB; lz4's errors are RuntimeErrors."""

_HEAD: Final = struct.Struct("<BQ")
_MESSAGE: Final = struct.Struct("<HIQQ")

_DECLARATIONS: Final[dict[int, type[Channel | Schema]]] = {Opcode.CHANNEL: Channel, Opcode.SCHEMA: Schema}
_ID_BYTES: Final = 2
"""A channel and a schema begin with their ids."""


class Piece(NamedTuple):
    """A message: its channel, its time in nanoseconds, its bytes."""

    channel: int
    time: int
    data: bytes


class TooMuch(Exception):
    """A file unpacks to more data than its size allows, as only a crafted file does."""


class Budget:
    """The limit of data that one pass over a file may unpack.

    Args:
        size: The size of the file in bytes.
    """

    def __init__(self, size: int) -> None:
        self._bytes = _FREE_BYTES + _MAX_RATIO * size
        self._messages = _FREE_MESSAGES + size // _BYTES_PER_MESSAGE
        self._known: set[tuple[int, bytes]] = set()

    def unpack(self, size: int) -> None:
        """Count unpacked bytes against the limit.

        Raises:
            TooMuch: The recording exceeds the limit.
        """
        self._bytes -= size
        if self._bytes < 0:
            raise TooMuch(f"it unpacks to more than {_MAX_RATIO} times its size")

    def message(self) -> None:
        """Count a message against the limit.

        Raises:
            TooMuch: The recording exceeds the limit.
        """
        self._messages -= 1
        if self._messages < 0:
            raise TooMuch(f"it has more than a message for each {_BYTES_PER_MESSAGE} bytes")

    def is_new(self, opcode: int, number: bytes) -> bool:
        """Return whether a channel or a schema is new: each chunk repeats those that it needs."""
        key = opcode, number
        if key in self._known:
            return False
        self._known.add(key)
        return True


def records(file: IO[bytes], size: int) -> Iterator[McapRecord]:
    """Yield the records of a file as far as they can be read; the last one of a complete file is a `Footer`.

    Raises:
        ValueError: The file is not MCAP.
    """
    reader = StreamReader(file, emit_chunks=True, record_size_limit=size)
    try:
        yield from reader.records
    except BROKEN:
        if file.seek(0) == 0 and file.read(len(MCAP0_MAGIC)) != MCAP0_MAGIC:
            raise ValueError("not MCAP") from None


def unpacked(chunk: Chunk, budget: Budget) -> Iterator[Piece | Channel | Schema]:
    """Yield the messages of a chunk, and the channels and schemas that were not declared before.

    Raises:
        ValueError: The chunk is damaged or too large.
        TooMuch: The file unpacks to too much data.
    """
    try:
        data = _data(chunk, budget)
        if chunk.uncompressed_crc and zlib.crc32(data) != chunk.uncompressed_crc:
            raise ValueError("a chunk with a wrong checksum")
        yield from _within(memoryview(data), budget)
    except BROKEN as error:
        raise ValueError(str(error)) from None


def _within(data: memoryview, budget: Budget) -> Iterator[Piece | Channel | Schema]:
    at = 0
    while at < len(data):
        opcode, length = _HEAD.unpack_from(data, at)
        at += _HEAD.size
        body = data[at : at + length]
        if len(body) < length:
            raise ValueError("a record is longer than its chunk")
        at += length
        if opcode == Opcode.MESSAGE:
            budget.message()
            channel, _, time, _ = _MESSAGE.unpack_from(body)
            yield Piece(channel, time, bytes(body[_MESSAGE.size :]))
        elif opcode not in _DECLARATIONS:
            raise ValueError("a record that does not belong in a chunk")
        elif budget.is_new(opcode, bytes(body[:_ID_BYTES])):
            yield _DECLARATIONS[opcode].read(ReadDataStream(BytesIO(body)))


def _data(chunk: Chunk, budget: Budget) -> bytes:
    size = chunk.uncompressed_size
    if size > MAX_UNPACKED:
        raise ValueError(f"a chunk of {size} bytes")
    match chunk.compression:
        case "zstd":
            if zstandard.get_frame_parameters(chunk.data).content_size not in (size, zstandard.CONTENTSIZE_UNKNOWN):
                raise ValueError("a chunk of the wrong size")
            budget.unpack(size)
            data = zstandard.ZstdDecompressor().decompress(chunk.data, max_output_size=size)
        case "lz4":
            budget.unpack(size)
            data = lz4.frame.LZ4FrameDecompressor().decompress(chunk.data, max_length=size + 1)
        case "":
            budget.unpack(len(chunk.data))
            data = chunk.data
        case other:
            raise ValueError(f"unknown compression {other!r}")
    if len(data) != size:
        raise ValueError("a chunk of the wrong size")
    return data
