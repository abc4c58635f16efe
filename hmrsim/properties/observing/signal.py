"""Signals: values that are constant between changes, and who wants to know when they change."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

HOLDS: Final = 1.0
FAILS: Final = -1.0
"""The robustness of what holds, or does not, if there is nothing to measure."""


class Signal:
    """A value that changes at times.

    Attributes:
        value: The robustness of what it says, or what it measures.
    """

    __slots__ = ("_told", "value")

    def __init__(self, value: float = FAILS) -> None:
        self.value = value
        self._told: list[Callable[[], object]] = []

    def set(self, value: float) -> None:
        """Let it have another value from now on."""
        if value != self.value:
            self.value = value
            for told in self._told:
                told()

    def say(self, *, holds: bool) -> None:
        """Let it hold from now on, or not."""
        self.set(HOLDS if holds else FAILS)

    def tell(self, told: Callable[[], object]) -> None:
        """Call a function with each change from now on."""
        self._told.append(told)

    def forget(self, told: Callable[[], object]) -> None:
        """Call it no longer."""
        self._told.remove(told)
