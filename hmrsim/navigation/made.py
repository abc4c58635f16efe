"""A sequence of values that are computed on first access."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Generic, TypeVar

T = TypeVar("T")


class Made(Generic[T]):
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
        """Compute all values."""
        return map(self.__getitem__, range(self._count))

    def __getitem__(self, number: int) -> T:
        """Return the value at an index."""
        values = self._values
        if number in values:
            return values[number]
        value = values[number] = self._make(number)
        return value
