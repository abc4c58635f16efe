"""Caches of navigation: a bounded one for costly values, and lazily computed mappings and sequences."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable, Iterator
from struct import pack
from typing import Generic, TypeVar

K = TypeVar("K", bound=Hashable)
V = TypeVar("V")


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


T = TypeVar("T")


class Memo(dict[K, V]):
    """The values of a function, each computed on first access: ``memo[key]``.

    Args:
        make: Computes the value of a key.
    """

    def __init__(self, make: Callable[[K], V]) -> None:
        super().__init__()
        self._make = make

    def __missing__(self, key: K) -> V:
        """Compute and keep the value of a new key."""
        value = self[key] = self._make(key)
        return value


class LazySequence(Generic[T]):
    """A sequence whose values are computed on first access.

    Args:
        count: The number of values.
        make: Computes the value at an index; it must not refer to the owner of the sequence, see `LruCache`.
    """

    def __init__(self, count: int, make: Callable[[int], T]) -> None:
        self._count = count
        self._make = make
        self._values: dict[int, T] = {}

    def __len__(self) -> int:
        """Return the number of values, computed or not."""
        return self._count

    def __iter__(self) -> Iterator[T]:
        """Iterate over all values, and compute those that are missing."""
        return map(self.__getitem__, range(self._count))

    def __getitem__(self, number: int) -> T:
        """Return the value at an index."""
        values = self._values
        if number in values:
            return values[number]
        value = values[number] = self._make(number)
        return value
