"""Reading of MCAP files record by record, without trust in the sizes that they claim."""

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

BROKEN: Final = (
    McapError, struct.error, ValueError, LookupError, OverflowError, EOFError, MemoryError, zstandard.ZstdError,
    RuntimeError,
)  # fmt: skip
"""The exceptions of reading invalid data, such as a claimed string of 4 GB; lz4's errors are RuntimeErrors."""

_HEAD: Final = struct.Struct("<BQ")
_MESSAGE: Final = struct.Struct("<HIQQ")


class Piece(NamedTuple):
    """A message: its channel, its time in nanoseconds, its bytes."""

    channel: int
    time: int
    data: bytes


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


def unpacked(chunk: Chunk) -> Iterator[Piece | Channel | Schema]:
    """Yield the records of a chunk.

    Raises:
        ValueError: The chunk is damaged or too large.
    """
    try:
        data = _data(chunk)
        if chunk.uncompressed_crc and zlib.crc32(data) != chunk.uncompressed_crc:
            raise ValueError("a chunk with a wrong checksum")
        yield from _within(memoryview(data))
    except BROKEN as error:
        raise ValueError(str(error)) from None


def _within(data: memoryview) -> Iterator[Piece | Channel | Schema]:
    at = 0
    while at < len(data):
        opcode, length = _HEAD.unpack_from(data, at)
        at += _HEAD.size
        body = data[at : at + length]
        if len(body) < length:
            raise ValueError("a record is longer than its chunk")
        at += length
        if opcode == Opcode.MESSAGE:
            channel, _, time, _ = _MESSAGE.unpack_from(body)
            yield Piece(channel, time, bytes(body[_MESSAGE.size :]))
        elif opcode == Opcode.CHANNEL:
            yield Channel.read(ReadDataStream(BytesIO(body)))
        elif opcode == Opcode.SCHEMA:
            yield Schema.read(ReadDataStream(BytesIO(body)))


def _data(chunk: Chunk) -> bytes:
    size = chunk.uncompressed_size
    if size > MAX_UNPACKED:
        raise ValueError(f"a chunk of {size} bytes")
    match chunk.compression:
        case "zstd":
            if zstandard.get_frame_parameters(chunk.data).content_size not in (size, zstandard.CONTENTSIZE_UNKNOWN):
                raise ValueError("a chunk of the wrong size")
            data = zstandard.ZstdDecompressor().decompress(chunk.data, max_output_size=size)
        case "lz4":
            data = lz4.frame.LZ4FrameDecompressor().decompress(chunk.data, max_length=size + 1)
        case "":
            data = chunk.data
        case other:
            raise ValueError(f"unknown compression {other!r}")
    if len(data) != size:
        raise ValueError("a chunk of the wrong size")
    return data
