"""Caches: bounded ones, mappings and sequences computed on access, and values of files while these stay the same."""

from __future__ import annotations

import stat
import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable, Iterable
from pathlib import Path
from struct import pack
from typing import Final, Generic, NamedTuple, TypeVar

K = TypeVar("K", bound=Hashable)
V = TypeVar("V")
T = TypeVar("T")


def exact(*numbers: float) -> bytes:
    """Return numbers as a key that distinguishes -0.0 from 0.0, which are equal but give different results."""
    return pack(f"{len(numbers)}d", *numbers)


class LruCache(Generic[K, V]):
    """A bounded cache that drops the least recently used value.

    `functools.lru_cache` around an object's own method would be a cycle, and such objects stay in memory until Python's
    garbage collector looks at all old objects, which may be hours later.
    """

    def __init__(self, most: int) -> None:
        self._most = most
        self._values: OrderedDict[K, V] = OrderedDict()

    def __contains__(self, key: K) -> bool:
        """Return whether the value of a key is cached."""
        return key in self._values

    def clear(self) -> None:
        """Drop all values."""
        self._values.clear()

    def get(self, key: K, make: Callable[[], V]) -> V:
        """Return the cached value of a key, computing it if necessary."""
        values = self._values
        try:
            value = values[key]
            # Another thread may have dropped it by now.
            values.move_to_end(key)
        except KeyError:
            pass
        else:
            return value
        value = values[key] = make()
        if len(values) > self._most:
            values.popitem(last=False)
        return value


class Memo(dict[K, V]):
    """The values of a function, each computed on first access: ``memo[key]``.

    Args:
        make: Computes the value of a key; it must not refer to the owner of the memo, see `LruCache`.
    """

    def __init__(self, make: Callable[[K], V]) -> None:
        super().__init__()
        self._make = make

    def __missing__(self, key: K) -> V:
        """Compute and keep the value of a new key."""
        value = self[key] = self._make(key)
        return value


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
        if entry is None or entry.contents != {file: _content(file) for file in entry.contents}:
            value = read()
            entry = _Entry(value, {Path(file): _content(Path(file)) for file in files(value)})
        with self._lock:
            self._entries.pop(key, None)
            if sum(map(len, filter(None, entry.contents.values()))) <= MAX_BYTES:
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
