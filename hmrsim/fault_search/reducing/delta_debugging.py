"""Delta debugging: the parts of a whole that are needed for a failure.

Zeller and Hildebrandt, "Simplifying and Isolating Failure-Inducing Input", IEEE TSE 28(2), 2002: ddmin. All candidates
of one round are tested together, and the first one in order that fails is taken, so that the result is the same
however many are tested at once.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import TypeVar

T = TypeVar("T")

Fails = Callable[[Sequence[Sequence[T]]], Sequence[bool]]
"""Tells of some candidates, each some parts in their order, whether they fail as the whole does."""


def needed(parts: Sequence[T], fails: Fails[T]) -> list[T]:
    """Return parts that fail together, of which none can be left out: they are 1-minimal.

    Args:
        parts: All parts, which fail together.
        fails: Tests candidates; it may say of all of them that they do not fail, when time is over.
    """
    kept = [*parts]
    if kept and fails([[]])[0]:
        return []
    pieces = 2
    while len(kept) > 1:
        pieces = min(pieces, len(kept))
        chunks = _chunks(kept, pieces)
        candidates = [] if pieces == 2 else [*chunks]  # noqa: PLR2004 - of two, each is the other's complement
        complements = [[part for chunk in chunks[:i] + chunks[i + 1 :] for part in chunk] for i in range(pieces)]
        verdicts = fails([*candidates, *complements])
        failing = next((i for i, failed in enumerate(verdicts) if failed), None)
        if failing is None:
            if pieces >= len(kept):
                break
            pieces *= 2
        elif failing < len(candidates):
            kept, pieces = [*candidates[failing]], 2
        else:
            kept, pieces = complements[failing - len(candidates)], max(2, pieces - 1)
    return kept


def _chunks(parts: Sequence[T], count: int) -> list[list[T]]:
    """Return parts in so many pieces of about the same length, in order."""
    ends = [round(len(parts) * i / count) for i in range(count + 1)]
    return [[*parts[start:end]] for start, end in pairwise(ends)]
