"""The container of a recording: an MCAP file, as the package `mcap` would write it, at a tenth of the cost a message.

A message is two pieces of bytes in a list, and two numbers in an index; all the rest is done once a chunk.
"""

from __future__ import annotations

import struct
import zlib
from collections import defaultdict
from typing import IO, TYPE_CHECKING, Final

import zstandard
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from mcap.records import McapRecord

MAGIC: Final = b"\x89MCAP0\r\n"

_CHUNK: Final = 1 << 20
"""Bytes with which a chunk is full."""
_LEVEL: Final = 1
"""Of zstd: what is recorded repeats itself so much that more of it finds nothing more."""

_MESSAGE: Final = struct.Struct("<BQHIQQ")
_FIELDS: Final = _MESSAGE.size - struct.calcsize("<BQ")
_INDEX: Final = struct.Struct("<BQHI")
_ENTRY: Final = struct.calcsize("<QQ")
_FOOTER: Final = struct.Struct("<BQQQ")


class Container:
    """Writes records; messages in chunks, in the order of their times.

    Args:
        file: Where to, from its beginning.
        library: Who writes it.
    """

    def __init__(self, file: IO[bytes], library: str) -> None:
        self._file = file
        self._written = 0
        self._schemas: list[Schema] = []
        self._channels: list[Channel] = []
        self._chunks: list[ChunkIndex] = []
        self._attachments: list[AttachmentIndex] = []
        self._metadata: list[MetadataIndex] = []
        self._counts: dict[int, int] = defaultdict(int)
        self._parts: list[bytes] = []
        self._size = 0
        self._index: dict[int, list[int]] = defaultdict(list)
        self._begin = self._end = 0
        self._write(MAGIC)
        self._write(_bytes_of([Header("ros2", library)]))

    def schema(self, name: str, encoding: str, data: bytes) -> int:
        """Add a schema; return its number."""
        self._schemas.append(Schema(id=len(self._schemas) + 1, name=name, encoding=encoding, data=data))
        self._put(_bytes_of(self._schemas[-1:]))
        return len(self._schemas)

    def channel(self, topic: str, message_encoding: str, schema: int, metadata: dict[str, str]) -> int:
        """Add a channel; return its number."""
        number = len(self._channels) + 1
        self._channels.append(
            Channel(id=number, topic=topic, message_encoding=message_encoding, metadata=metadata, schema_id=schema)
        )
        self._put(_bytes_of(self._channels[-1:]))
        return number

    def message(self, channel: int, time: int, data: bytes) -> bool:
        """Add a message, no earlier than those before; return whether the chunk is full."""
        if not self._index:
            self._begin = time
        self._end = time
        self._index[channel] += (time, self._size)
        self._parts += (_MESSAGE.pack(Opcode.MESSAGE, _FIELDS + len(data), channel, 0, time, time), data)
        self._size += _MESSAGE.size + len(data)
        return self._size >= _CHUNK

    def metadata(self, name: str, values: dict[str, str]) -> None:
        """Add what is to be known of the file."""
        data = _bytes_of([Metadata(name=name, metadata=values)])
        self._metadata.append(MetadataIndex(offset=self._written, length=len(data), name=name))
        self._write(data)

    def attachment(self, name: str, media_type: str, content: bytes) -> None:
        """Add a file."""
        times = {"create_time": 0, "log_time": 0}
        data = _bytes_of([Attachment(**times, name=name, media_type=media_type, data=content)])
        self._attachments.append(
            AttachmentIndex(
                **times,
                offset=self._written,
                length=len(data),
                data_size=len(content),
                name=name,
                media_type=media_type,
            )
        )
        self._write(data)

    def flush(self) -> None:
        """Write the chunk that was begun, if there is a message in it."""
        if self._index:
            self._finish_chunk()
        self._file.flush()

    def finish(self) -> None:
        """Write what makes the file complete: the index."""
        if self._index:
            self._finish_chunk()
        self._write(_bytes_of([DataEnd(data_section_crc=0)]))
        start, summary, offsets = self._written, b"", []
        groups: Sequence[tuple[Opcode, Sequence[McapRecord]]] = (
            (Opcode.SCHEMA, self._schemas),
            (Opcode.CHANNEL, self._channels),
            (Opcode.STATISTICS, [self._statistics()]),
            (Opcode.CHUNK_INDEX, self._chunks),
            (Opcode.ATTACHMENT_INDEX, self._attachments),
            (Opcode.METADATA_INDEX, self._metadata),
        )
        for opcode, group in groups:
            data = _bytes_of(group)
            if data:
                offsets.append(SummaryOffset(opcode, start + len(summary), len(data)))
            summary += data
        offset_start = start + len(summary)
        summary += _bytes_of(offsets)
        footer = _FOOTER.pack(Opcode.FOOTER, _FOOTER.size - struct.calcsize("<BQ") + 4, start, offset_start)
        crc = zlib.crc32(footer, zlib.crc32(summary))
        self._write(summary + _bytes_of([Footer(start, offset_start, crc)]) + MAGIC)

    def _put(self, record: bytes) -> None:
        """Put something into the chunk that is no message."""
        self._parts.append(record)
        self._size += len(record)

    def _finish_chunk(self) -> None:
        data = b"".join(self._parts)
        packed = zstandard.compress(data, _LEVEL)
        times = {"message_start_time": self._begin, "message_end_time": self._end}
        chunk = _bytes_of(
            [
                Chunk(
                    **times,
                    compression="zstd",
                    data=packed,
                    uncompressed_crc=zlib.crc32(data),
                    uncompressed_size=len(data),
                )
            ]
        )
        index, at = [], {}
        begin = after = self._written + len(chunk)
        for channel, entries in self._index.items():
            at[channel] = after
            length = len(entries) // 2 * _ENTRY
            index.append(_INDEX.pack(Opcode.MESSAGE_INDEX, length + 6, channel, length))
            index.append(struct.pack(f"<{len(entries)}Q", *entries))
            after += _INDEX.size + length
            self._counts[channel] += len(entries) // 2
        self._chunks.append(
            ChunkIndex(
                **times,
                chunk_start_offset=self._written,
                chunk_length=len(chunk),
                message_index_offsets=at,
                message_index_length=after - begin,
                compression="zstd",
                compressed_size=len(packed),
                uncompressed_size=len(data),
            )
        )
        self._parts, self._size = [], 0
        self._index.clear()
        self._write(b"".join([chunk, *index]))

    def _statistics(self) -> Statistics:
        return Statistics(
            attachment_count=len(self._attachments),
            channel_count=len(self._channels),
            channel_message_counts=self._counts,
            chunk_count=len(self._chunks),
            message_count=sum(self._counts.values()),
            message_start_time=self._chunks[0].message_start_time if self._chunks else 0,
            message_end_time=self._chunks[-1].message_end_time if self._chunks else 0,
            metadata_count=len(self._metadata),
            schema_count=len(self._schemas),
        )

    def _write(self, data: bytes) -> None:
        self._file.write(data)
        self._written += len(data)


def _bytes_of(records: Sequence[McapRecord]) -> bytes:
    builder = RecordBuilder()
    for record in records:
        record.write(builder)
    data: bytes = builder.end()  # type: ignore[no-untyped-call]  # has no types
    return data
