"""A cache of values read from files, valid while the files stay the same."""

from __future__ import annotations

import stat
import threading
from collections.abc import Callable, Hashable, Iterable
from pathlib import Path
from typing import Final, Generic, NamedTuple, TypeVar

T = TypeVar("T")

MAX_BYTES: Final = 2**20
"""Maximum size of the files of a value; larger ones are read each time, as caching them would fill the memory."""


class _Entry(NamedTuple, Generic[T]):
    value: T
    contents: dict[Path, bytes | None]


class FileCache(Generic[T]):
    """A cache of values read from files; compares the contents of the files to detect a change.

    Args:
        max_entries: The maximum number of values; the least recently used one is dropped.
    """

    def __init__(self, max_entries: int = 64) -> None:
        self._max_entries = max_entries
        self._entries: dict[Hashable, _Entry[T]] = {}
        self._lock = threading.Lock()

    def get(self, key: Hashable, read: Callable[[], T], files: Callable[[T], Iterable[str | Path]]) -> T:
        """Return the value of a key; read it if it is not cached or a file has changed.

        Args:
            key: Identifies everything but the files that *read* depends on.
            read: Reads the value; its errors are not cached.
            files: Returns the files from which a value was read, and those that *read* found missing.
        """
        entry = self._entries.get(key)
        if entry is None or any(_content(file) != content for file, content in entry.contents.items()):
            value = read()
            entry = _Entry(value, {Path(file): _content(Path(file)) for file in files(value)})
        with self._lock:
            self._entries.pop(key, None)
            if sum(len(content or b"") for content in entry.contents.values()) <= MAX_BYTES:
                self._entries[key] = entry
                if len(self._entries) > self._max_entries:
                    del self._entries[next(iter(self._entries))]
        return entry.value


def _content(file: Path) -> bytes | None:
    """Return the content of a file, or the beginning of a large one; empty for a pipe or folder, None if missing."""
    try:
        # A named pipe might never end.
        if not stat.S_ISREG(file.stat().st_mode):
            return b""
        with file.open("rb") as stream:
            return stream.read(MAX_BYTES + 1)
    except (OSError, ValueError):  # ValueError: the name is not a possible file name
        return None
