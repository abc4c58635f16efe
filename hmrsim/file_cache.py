"""What was read from files, kept while the files stay the same."""

from __future__ import annotations

import stat
import threading
from collections.abc import Callable, Hashable, Iterable
from pathlib import Path
from typing import Final, Generic, NamedTuple, TypeVar

T = TypeVar("T")

MAX_BYTES: Final = 2**20
"""Files of more than so much, together, are read each time: what is kept of them would fill the memory."""


class _Entry(NamedTuple, Generic[T]):
    value: T
    contents: dict[Path, bytes | None]


class FileCache(Generic[T]):
    """Values that follow from the contents of files; a file that has changed is noticed by its content.

    Args:
        most: The number of values that are kept: those that were asked for last.
    """

    def __init__(self, most: int = 64) -> None:
        self._most = most
        self._entries: dict[Hashable, _Entry[T]] = {}
        self._lock = threading.Lock()

    def get(self, key: Hashable, read: Callable[[], T], files: Callable[[T], Iterable[str | Path]]) -> T:
        """Return the value of a key.

        Args:
            key: It must tell apart all that *read* depends on beside the contents of the files.
            read: Returns the value anew; an error that it raises is passed on, and is not kept.
            files: Returns the files from which a value was read, and those that were looked for and are absent.
        """
        entry = self._entries.get(key)
        if entry is None or any(_content(file) != content for file, content in entry.contents.items()):
            value = read()
            entry = _Entry(value, {Path(file): _content(Path(file)) for file in files(value)})
        with self._lock:
            self._entries.pop(key, None)
            if sum(len(content or b"") for content in entry.contents.values()) <= MAX_BYTES:
                self._entries[key] = entry
                if len(self._entries) > self._most:
                    del self._entries[next(iter(self._entries))]
        return entry.value


def _content(file: Path) -> bytes | None:
    """Return the content of a file, or its beginning if it is large; nothing if it is none, None if it is absent."""
    try:
        # A named pipe might never end.
        if not stat.S_ISREG(file.stat().st_mode):
            return b""
        with file.open("rb") as stream:
            return stream.read(MAX_BYTES + 1)
    except (OSError, ValueError):  # ValueError: of a name that can't be one
        return None
