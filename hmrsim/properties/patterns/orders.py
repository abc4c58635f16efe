"""The orders in which places may be reached, as automata over arrivals."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol


class Order(Protocol):
    """What may be reached next."""

    def arrive(self, place: int) -> str:
        """Take note of an arrival; return what is wrong with it, or an empty text.

        Args:
            place: The number of the place, from 0.
        """


class AnyOrder:
    """Nothing is wrong."""

    def __init__(self, _count: int) -> None:
        pass

    def arrive(self, _place: int) -> str:
        """Return an empty text."""
        return ""


class FirstInOrder:
    """No place is reached the first time before the one that precedes it: (not l2) U l1, and so on."""

    def __init__(self, _count: int) -> None:
        self._reached = 0

    def arrive(self, place: int) -> str:
        """Return whether it comes too early."""
        if place > self._reached:
            return "too early"
        self._reached += place == self._reached
        return ""


class FirstInStrictOrder:
    """Likewise, and after its first arrival no place is reached again before the next one is.

    (not l1) U (l1 and X ((not l1) U l2)), and so on.
    """

    def __init__(self, count: int) -> None:
        self._count = count
        self._reached = 0

    def arrive(self, place: int) -> str:
        """Return whether it comes too early, or again."""
        if place > self._reached:
            return "too early"
        if place == self._reached:
            self._reached += 1
        elif place == self._reached - 1 and self._reached < self._count:
            return "again too early"
        return ""


class Fair:
    """After a place the next one, in a circle, is reached before it is reached again: G (l1 -> X ((not l1) W l2))."""

    def __init__(self, count: int) -> None:
        self._reached = [False] * count

    def arrive(self, place: int) -> str:
        """Return whether it comes again too early."""
        wrong = "again too early" if self._reached[place] and len(self._reached) > 1 else ""
        self._reached[place - 1] = False
        self._reached[place] = True
        return wrong


class RoundsInOrder:
    """No place is reached before the one that precedes it, in a circle: (not l2) U l1, G (l2 -> X ((not l2) U l1)).

    The until is a weak one, as a patrol goes on when a run ends.
    """

    def __init__(self, count: int) -> None:
        self._free = [place == 0 for place in range(count)]

    def arrive(self, place: int) -> str:
        """Return whether it comes too early."""
        wrong = "" if self._free[place] else "too early"
        self._free[place] = False
        self._free[(place + 1) % len(self._free)] = True
        return wrong


class RoundsInStrictOrder(RoundsInOrder):
    """Likewise, and each place but the last is followed by the next one: G (l1 -> X ((not l1) U l2)), too."""

    def __init__(self, count: int) -> None:
        super().__init__(count)
        self._reached = [False] * count

    def arrive(self, place: int) -> str:
        """Return whether it comes too early, or again."""
        wrong = super().arrive(place)
        again = "again too early" if self._reached[place] and place + 1 < len(self._reached) else ""
        self._reached[place - 1] = False
        self._reached[place] = True
        return again or wrong


Made = Callable[[int], Order]
"""Makes an order of so many places."""
