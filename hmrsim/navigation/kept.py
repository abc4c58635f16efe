"""Caches of navigation: a bounded one for costly values, and lazily computed sequences."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable
from struct import pack
from typing import Generic, TypeVar

K = TypeVar("K", bound=Hashable)
V = TypeVar("V")


def exact(*numbers: float) -> bytes:
    """Return numbers as a key that distinguishes -0.0 from 0.0, which are equal but give different results."""
    return pack(f"{len(numbers)}d", *numbers)


class Kept(Generic[K, V]):
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
