"""Values that are kept because they took time to make: the ones that were used last."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable
from struct import pack
from typing import Generic, TypeVar

K = TypeVar("K", bound=Hashable)
V = TypeVar("V")


def exact(*numbers: float) -> bytes:
    """Return numbers as a key that tells -0.0 from 0.0: they are equal, but what is kept for one shows the other's."""
    return pack(f"{len(numbers)}d", *numbers)


class Kept(Generic[K, V]):
    """At most so many values; the one that was used least recently is dropped.

    `functools.lru_cache` around an object's own method would be a cycle, and such objects stay in memory until Python's
    garbage collector looks at all old objects, which may be hours later.
    """

    def __init__(self, most: int) -> None:
        self._most = most
        self._values: OrderedDict[K, V] = OrderedDict()

    def __contains__(self, key: K) -> bool:
        """Return whether the value of a key is kept."""
        return key in self._values

    def get(self, key: K, make: Callable[[], V]) -> V:
        """Return the value of a key, made now unless it is kept."""
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
