"""Writing of MCAP files, which can be read up to the last seconds after a crash, and the schemas of JSON channels."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable
from contextlib import suppress
from typing import IO, TYPE_CHECKING, Any, Final, NamedTuple, Self

from mcap.writer import Writer

from hmrsim import __version__
from hmrsim.errors import HmrsimError
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.program.files import unwritable
from hmrsim.world_checks.schema import world_schema
from hmrsim_zenoh.wire.descriptions import TreeState

if TYPE_CHECKING:
    from pathlib import Path

FLUSH_SECONDS: Final = 2.0
"""Wall seconds after which a message is in the file, at the latest."""
_FLUSH_SIMULATED: Final = 5 * NANOSECONDS
"""Simulated nanoseconds after which a message is in a reproducible file, at the latest."""

_JOIN_SECONDS: Final = 1.0


class Schema(NamedTuple):
    """The schema of a channel.

    Attributes:
        encoding: The encoding of *text*: ``ros2msg`` or ``jsonschema``.
        message_encoding: The encoding of messages: ``cdr`` or ``json``.
    """

    name: str
    encoding: str
    text: str
    message_encoding: str


class RecordingFile:
    """Writes messages in chunks, each of which is in the file shortly after; for one thread.

    Args:
        path: The file; an existing one is overwritten.
        reproducible: Whether the same messages have to produce the same file: chunks then end by simulated time.

    Raises:
        OutputError: The file can't be opened.
    """

    def __init__(self, path: Path, *, reproducible: bool = False) -> None:
        self.path = path
        self._file = _opened(path)
        self._reproducible = reproducible
        self._writer = Writer(self._file)
        self._lock = threading.Lock()
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}
        self._begun = 0
        self._error: OSError | None = None
        self._closed = threading.Event()
        self.messages = 0
        self._writer.start(profile="ros2", library=f"hmrsim {__version__}")
        self._thread = threading.Thread(target=self._flush_regularly, name="hmrsim-recording", daemon=True)
        if not reproducible:
            self._thread.start()

    def __enter__(self) -> Self:
        """Return the file."""
        return self

    def __exit__(self, kind: type[BaseException] | None, *_error: object) -> None:
        """Close the file; after another error a failure to write is ignored."""
        with suppress(*([HmrsimError] if kind else [])):
            self.close()

    def channel(self, topic: str, schema: Schema, metadata: dict[str, str] | None = None) -> int:
        """Return the id of a channel, which is created at the first call.

        Raises:
            HmrsimError: The file can't be written.
        """
        known = self._channels.get(topic)
        if known is None:
            known = self._channels[topic] = self._write(self._register, topic, schema, metadata or {})
        return known

    def _register(self, topic: str, schema: Schema, metadata: dict[str, str]) -> int:
        if schema.name not in self._schemas:
            self._schemas[schema.name] = self._writer.register_schema(
                schema.name, schema.encoding, schema.text.encode()
            )
        return self._writer.register_channel(topic, schema.message_encoding, self._schemas[schema.name], metadata)

    def add(self, channel: int, time: int, data: bytes) -> None:
        """Write a message of a channel; *time* in nanoseconds.

        Raises:
            HmrsimError: The file can't be written.
        """
        self._write(self._writer.add_message, channel, time, data, time)
        self.messages += 1
        if self._reproducible and time - self._begun >= _FLUSH_SIMULATED:
            self._begun = time
            self._write(self._writer.flush)

    def describe(self, name: str, values: dict[str, str]) -> None:
        """Write metadata of the recording.

        Raises:
            HmrsimError: The file can't be written.
        """
        self._write(self._writer.add_metadata, name, values)

    def attach(self, name: str, media_type: str, data: bytes) -> None:
        """Attach a file to the recording.

        Raises:
            HmrsimError: The file can't be written.
        """
        self._write(self._writer.add_attachment, 0, 0, name, media_type, data)

    def close(self) -> None:
        """Write the index, without which a reader has to scan the whole file.

        Raises:
            HmrsimError: The file can't be written.
        """
        if self._closed.is_set():
            return
        self._closed.set()
        if self._thread.is_alive():
            self._thread.join(_JOIN_SECONDS)
        try:
            self._write(self._writer.finish)
            self._write(self._file.flush)
        finally:
            # Closing would try to write the failed bytes again.
            with suppress(OSError):
                self._file.close()

    def _flush_regularly(self) -> None:
        flushed = 0
        while not self._closed.wait(FLUSH_SECONDS):
            if self.messages == flushed or self._error:
                continue
            with self._lock:
                if self._closed.is_set():
                    # It was closed while this thread waited for the lock.
                    return
                flushed = self.messages
                try:
                    self._writer.flush()  # type: ignore[no-untyped-call]
                except OSError as error:
                    self._error = error

    def _write(self, call: Callable[..., Any], *arguments: Any) -> Any:
        """Call a function that writes; raise its error, or that of the background thread, as `HmrsimError`."""
        with self._lock:
            if self._error is None:
                try:
                    return call(*arguments)
                except OSError as error:
                    self._error = error
            raise unwritable(str(self.path), self._error) from None


def _opened(path: Path) -> IO[bytes]:
    try:
        return path.open("wb")
    except OSError as error:
        raise unwritable(str(path), error) from None


_STAMP: Final = {
    "type": "object",
    "properties": {"sec": {"type": "integer"}, "nanosec": {"type": "integer"}},
    "description": "Simulated time.",
}
_TEXT: Final = {"type": "string"}


def _object(*lists: str, **properties: Any) -> dict[str, Any]:
    """Return the schema of an object with these properties and these lists of objects; others are allowed."""
    listed = {name: {"type": "array", "items": {"type": "object"}} for name in lists}
    return {"type": "object", "properties": {**properties, **listed}}


def _json_schema(name: str, schema: dict[str, Any]) -> Schema:
    return Schema(name, "jsonschema", json.dumps(schema), "json")


EVENT_SCHEMA: Final = _json_schema("hmrsim/Event", _object(stamp=_STAMP, kind=_TEXT, robot=_TEXT))
SCENE_SCHEMA: Final = _json_schema(
    "hmrsim/Scene", _object("robots", "items", "fixtures", "closed_lanes", "faults", stamp=_STAMP)
)
INFO_SCHEMA: Final = _json_schema(
    "hmrsim/WorldInfo", _object("robots", "services", contract={"type": "integer"}, world=_object(name=_TEXT))
)


def world_definition_schema() -> Schema:
    """Return the schema of worlds."""
    return _json_schema("hmrsim/World", world_schema())


def tree_schema() -> Schema:
    """Return the schema of the tree states that controllers publish."""
    return _json_schema("hmrsim/Tree", TreeState.model_json_schema(mode="serialization"))
