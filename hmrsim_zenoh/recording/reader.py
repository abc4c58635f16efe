"""Reading of recordings, including truncated ones."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, Final

from mcap.records import Channel, Chunk, Footer, Message, Metadata, Schema

from hmrsim.errors import RecordingError, reason_of
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.interfaces.sensor_msgs import BatteryState
from hmrsim.program.files import MAX_VALUES, MAX_VALUES_OF_WORLD, check_regular, has_more_values
from hmrsim_zenoh.recording.chunks import Budget, Piece, TooMuch, records, unpacked
from hmrsim_zenoh.recording.recorder import ABOUT, EVENTS, INFO, SCENE, WORLD_TOPIC
from hmrsim_zenoh.ros2.codec.layout import CdrError
from hmrsim_zenoh.ros2.codec.types import message_type
from hmrsim_zenoh.wire.keys import TREE

if TYPE_CHECKING:
    from pathlib import Path

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
        RecordingError: The file is not a recording of hmrsim.
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
