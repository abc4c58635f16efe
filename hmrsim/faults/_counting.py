"""Faults that hit so many goals, and then are over."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hmrsim.faults import Case


class Countdown:
    """Ends a fault when it has hit so many goals; with None it hits all of them while it lasts.

    Args:
        hit: Begins the effect; is given what to call with each goal, and returns what ends the effect.
    """

    def __init__(
        self, case: Case[Any], count: int | None, hit: Callable[[Callable[[], None]], Callable[[], None]]
    ) -> None:
        self._case = case
        self._left = count
        self.end = hit(self._done)

    def _done(self) -> None:
        if self._left is None:
            return
        self._left -= 1
        if self._left == 0:
            self.end()
            self._case.finish()
