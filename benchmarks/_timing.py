"""Wall times that can be compared: variants take turns, so that a busy moment of the machine meets each of them."""

from __future__ import annotations

import statistics
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence


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
    """Return each variant's median wall seconds over some rounds, after one that isn't counted."""
    taken: dict[str, list[float]] = {variant.name: [] for variant in variants}
    for _ in range(rounds + 1):
        for variant in variants:
            began = time.perf_counter()
            variant.timed()
            taken[variant.name].append(time.perf_counter() - began)
            variant.after()
    return {name: statistics.median(times[1:]) for name, times in taken.items()}
