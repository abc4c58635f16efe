"""Values that are made when they are first asked for."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Generic, TypeVar

T = TypeVar("T")


class Made(Generic[T]):
    """So many values, by number; each is made when it is first asked for.

    Args:
        count: How many there are.
        make: Makes the value of a number from 0 on; it must not refer to what holds this, see `hmrsim.navigation.kept`.
    """

    def __init__(self, count: int, make: Callable[[int], T]) -> None:
        self._count = count
        self._make = make
        self._values: dict[int, T] = {}

    def __len__(self) -> int:
        """Return how many there are, made or not."""
        return self._count

    def __iter__(self) -> Iterator[T]:
        """Make all values."""
        return map(self.__getitem__, range(self._count))

    def __getitem__(self, number: int) -> T:
        """Return a value."""
        values = self._values
        if number in values:
            return values[number]
        value = values[number] = self._make(number)
        return value
