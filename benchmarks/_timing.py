"""Wall times that can be compared: variants take turns, so that a busy moment of the machine meets each of them.

Each turn is a few calls of the same: what a call needs is then in the processor's caches, as in a program that
does it all day, and not what another variant has left there.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

_TURN = 6
"""Calls of one variant in a row."""


def _nothing() -> None:
    """Do nothing."""


@dataclass(frozen=True)
class Variant:
    """Something to time.

    Attributes:
        name: What it is called.
        timed: What is timed.
        after: What puts everything back, untimed.
    """

    name: str
    timed: Callable[[], object]
    after: Callable[[], object] = _nothing


def medians(variants: Sequence[Variant], rounds: int) -> dict[str, float]:
    """Return each variant's median wall seconds over some rounds; the first call of each turn isn't counted."""
    taken: dict[str, list[float]] = {variant.name: [] for variant in variants}
    for _ in range(-(-rounds // (_TURN - 1))):
        for variant in variants:
            for number in range(_TURN):
                began = time.perf_counter()
                variant.timed()
                seconds = time.perf_counter() - began
                variant.after()
                if number:
                    taken[variant.name].append(seconds)
    return {name: statistics.median(times) for name, times in taken.items()}
