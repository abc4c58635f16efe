"""Reading of recordings record by record, including truncated ones, without trusting the sizes that they claim."""

from __future__ import annotations

import json
import struct
import zlib
from collections.abc import Callable, Iterator
from io import BytesIO
from typing import IO, TYPE_CHECKING, Any, Final, NamedTuple

import lz4.frame  # type: ignore[import-untyped]  # has no stubs
import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Footer, Message, Metadata, Schema
from mcap.stream_reader import StreamReader
from mcap.writer import MCAP0_MAGIC

from hmrsim.errors import RecordingError, reason_of
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.interfaces.sensor_msgs import BatteryState
from hmrsim.program.files import MAX_VALUES, MAX_VALUES_OF_WORLD, check_regular, has_more_values
from hmrsim_zenoh.recording.recorder import ABOUT, EVENTS, INFO, SCENE, WORLD_TOPIC
from hmrsim_zenoh.ros2.codec.layout import CdrError
from hmrsim_zenoh.ros2.codec.types import message_type
from hmrsim_zenoh.wire.keys import TREE

if TYPE_CHECKING:
    from pathlib import Path

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


_OWN_TOPICS: Final = (EVENTS, SCENE, INFO, WORLD_TOPIC)
_BATTERY: Final = "battery_state"


class Recording:
    """A recording, whose file is read again for each iteration.

    Attributes:
        world: The initial world, in the native format.
        info: The simulator's description, as on ``_world/info``.
        about: The metadata of the recording, such as the version that wrote it, and the seed if it is known.
        begin: The time of the first message, in nanoseconds of the recording's time: simulated time that continues
            after a reset.
        end: The time of the last message.
        truncated: Whether the end is missing, or a part that was read is damaged.

    Raises:
        RecordingError: The file can't be read, or is not a recording of hmrsim.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.begin = self.end = 0
        self.truncated = True
        self.about: dict[str, str] = {}
        self._scan()
        first = self._first_of((WORLD_TOPIC, INFO))
        self.world, self.info = first[WORLD_TOPIC], first[INFO]

    @property
    def name(self) -> str:
        """The name of the file."""
        return self.path.name

    def events(self) -> Iterator[dict[str, Any]]:
        """Yield all events as on ``_world/events``, in order.

        Raises:
            RecordingError: An event can't be read.
        """
        for topic, time, data in self._messages(lambda topic: topic == EVENTS):
            yield self._event(topic, time, data)

    def samples(self) -> Iterator[tuple[int, str, dict[str, Any]]]:
        """Yield time, key and payload of the page's messages, in order: events, scenes, worlds, batteries, trees.

        Raises:
            RecordingError: A message can't be read.
        """
        decode = message_type(BatteryState).decode
        for topic, time, data in self._messages(_is_for_the_page):
            key = topic.removeprefix("/")
            if topic == EVENTS:
                yield time, key, self._event(topic, time, data)
            elif not topic.endswith(f"/{_BATTERY}"):
                yield time, key, self._json(topic, time, data)
            else:
                try:
                    yield time, key, decode(data)
                except CdrError as error:
                    raise self._invalid(topic, time, str(error)) from None

    def _scan(self) -> None:
        """Find the time range and whether the file is complete and a recording, without unpacking chunks.

        Raises:
            RecordingError: The file can't be read, or is not a recording of hmrsim.
        """
        times: list[int] = []
        topics: set[str] = set()
        for record in self._records():
            match record:
                case Chunk():
                    times += (record.message_start_time, record.message_end_time)
                    topics.clear()
                case Message():
                    times.append(record.log_time)
                    topics.clear()
                case Channel():
                    topics.add(record.topic)
                case Metadata() if record.name == ABOUT:
                    self.about = record.metadata
                case Footer():
                    self.truncated = False
            times = [min(times), max(times)] if times else []
        if times:
            self.begin, self.end = times
        # The channels after the last message are those of the index, which lists all.
        if not self.truncated and topics and EVENTS not in topics:
            raise self._no_messages(EVENTS)

    def _first_of(self, topics: tuple[str, ...]) -> dict[str, dict[str, Any]]:
        """Return the first message of each topic.

        Raises:
            RecordingError: A topic has no message.
        """
        messages: dict[str, dict[str, Any]] = {}
        for topic, time, data in self._messages(lambda topic: topic in topics):
            messages.setdefault(topic, self._json(topic, time, data))
            if len(messages) == len(topics):
                return messages
        raise self._no_messages(next(topic for topic in topics if topic not in messages))

    def _messages(self, wanted: Callable[[str], bool]) -> Iterator[tuple[str, int, bytes]]:
        """Yield topic, time and bytes of the messages on the wanted topics; damaged chunks are skipped."""
        topics: dict[int, str] = {}
        for piece in self._pieces():
            if isinstance(piece, Piece):
                if piece.channel in topics:
                    yield topics[piece.channel], piece.time, piece.data
            elif isinstance(piece, Channel) and wanted(piece.topic):
                topics[piece.id] = piece.topic

    def _pieces(self) -> Iterator[Piece | Channel | Schema]:
        budget = Budget(self._size())
        for record in self._records():
            match record:
                case Chunk():
                    try:
                        yield from unpacked(record, budget)
                    except TooMuch as error:
                        raise RecordingError(f"{self.path}: not a recording: {error}") from None
                    except ValueError:
                        self.truncated = True
                case Message():
                    yield Piece(record.channel_id, record.log_time, record.data)
                case Channel() | Schema():
                    yield record

    def _size(self) -> int:
        try:
            return self.path.stat().st_size
        except OSError as error:
            raise RecordingError(f"{self.path}: can't be read: {reason_of(error)}") from None

    def _records(self) -> Iterator[Any]:
        try:
            check_regular(self.path)
            with self.path.open("rb") as file:
                yield from records(file, self._size())
        except OSError as error:
            raise RecordingError(f"{self.path}: can't be read: {reason_of(error)}") from None
        except ValueError:
            raise RecordingError(f"{self.path}: not a recording: not an MCAP file") from None

    def _event(self, topic: str, time: int, data: bytes) -> dict[str, Any]:
        match event := self._json(topic, time, data):
            case {"kind": str(), "stamp": {"sec": int(), "nanosec": int()}}:
                return event
        raise self._invalid(topic, time, "not an event")

    def _json(self, topic: str, time: int, data: bytes) -> dict[str, Any]:
        most = MAX_VALUES_OF_WORLD if topic == WORLD_TOPIC else MAX_VALUES
        if has_more_values(data, most):
            raise self._invalid(topic, time, f"more than {most} values")
        try:
            value = json.loads(data)
        except (ValueError, RecursionError):
            value = None
        if not isinstance(value, dict):
            raise self._invalid(topic, time, "not a JSON object")
        return value

    def _invalid(self, topic: str, time: int, why: str) -> RecordingError:
        return RecordingError(f"{self.path}: {topic} at {time / NANOSECONDS:.3f} s: {why}")

    def _no_messages(self, topic: str) -> RecordingError:
        return RecordingError(
            f"{self.path}: not a recording of hmrsim: there are no messages on {topic}; "
            "make one with `hmrsim run WORLD --record FILE.mcap` or `hmrsim record FILE.mcap`"
        )


def open_recording(path: Path) -> Recording:
    """Return a recording.

    Raises:
        RecordingError: The file can't be read, or is not a recording of hmrsim.
    """
    return Recording(path)


def _is_for_the_page(topic: str) -> bool:
    return topic in _OWN_TOPICS or topic.endswith((f"/{_BATTERY}", f"/{TREE}"))
