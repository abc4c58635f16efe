"""Buildings of several levels in one plane: the levels side by side, and names that tell them apart."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence

GAP = 5.0
"""Metres between two levels."""


def side_by_side(levels: Sequence[Iterable[complex]]) -> list[float]:
    """Return how far each level is moved along x, given the points of each; the first stays where it is."""
    shifts: list[float] = []
    end: float | None = None
    for points in levels:
        xs = [point.real for point in points]
        shift = end + GAP - min(xs) if end is not None and xs else 0.0
        shifts.append(shift)
        end = max(xs) + shift if xs else end
    return shifts


class Names:
    """The names of one kind of thing on all levels.

    Args:
        several: Whether there is more than one level.
        wanted: The names that things have on their own levels, by level.
    """

    def __init__(self, wanted: Sequence[Iterable[str]], *, several: bool) -> None:
        self._several = several
        self._clashing = {
            name for name, count in Counter(name for names in wanted for name in set(names)).items() if count > 1
        }
        self._taken: set[str] = set()

    def give(self, level: str, own: str, number: str) -> str:
        """Return what a thing is called: *own* if that is one of its kind, else with its *level* or as *number*.

        Args:
            level: The name of its level.
            own: The name that it has there; empty for none.
            number: What it is called there if it has none, or one that is taken.
        """
        candidates = [own] if own not in ("", *self._clashing) else []
        candidates += [f"{level}/{own}"] if own else []
        candidates += [f"{level}/{number}" if self._several else number]
        name = next((name for name in candidates if name not in self._taken), candidates[-1])
        while name in self._taken:
            name += "_"
        self._taken.add(name)
        return name
