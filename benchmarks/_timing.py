"""Wall times that can be compared: variants take turns, so that a busy moment of the machine meets each of them.

Each turn is a few calls of the same: what a call needs is then in the processor's caches, as in a program that
does it all day, and not what another variant has left there.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from benchmarks._spread import Spread

_TURN = 6
"""Calls of one variant in a row."""


def _nothing() -> None:
    """Do nothing after a call."""


def _as_it_is(seconds: float) -> float:
    return seconds


def microseconds(seconds: float) -> float:
    """Return seconds as microseconds."""
    return seconds * 1e6


@dataclass(frozen=True)
class Variant:
    """A function to time, with its name and clean-up.

    Attributes:
        name: The name of the variant.
        timed: The function to time.
        after: Restores the initial state after each call, untimed.
    """

    name: str
    timed: Callable[[], object]
    after: Callable[[], object] = _nothing


@dataclass(frozen=True)
class Rounds:
    """The times of variants that took turns.

    Attributes:
        taken: By variant, its seconds in each round; the rounds of all variants are the same.
    """

    taken: Mapping[str, Sequence[float]]

    def spread(self, name: str, figure: Callable[[float], float] = _as_it_is) -> Spread:
        """Return the spread of a variant's seconds, or of a *figure* that follows from them."""
        return Spread.of(figure(seconds) for seconds in self.taken[name])

    def ratio(self, name: str, to: str) -> Spread:
        """Return how much longer a variant took than another one, round by round."""
        return Spread.of(mine / other for mine, other in zip(self.taken[name], self.taken[to], strict=True))


def interleaved(variants: Sequence[Variant], calls: int) -> Rounds:
    """Return what each variant's turns took in wall seconds a call: the median of the turn, its first call left out.

    There are as many rounds as it takes for that many *calls* of each.
    """
    taken: dict[str, list[float]] = {variant.name: [] for variant in variants}
    for _ in range(-(-calls // (_TURN - 1))):
        for variant in variants:
            taken[variant.name].append(statistics.median(_turn(variant)))
    return Rounds(taken)


def _turn(variant: Variant) -> list[float]:
    seconds = []
    for _ in range(_TURN):
        began = time.perf_counter()
        variant.timed()
        seconds.append(time.perf_counter() - began)
        variant.after()
    return seconds[1:]
