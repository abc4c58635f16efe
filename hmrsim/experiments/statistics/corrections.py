"""Several tests at once: p-values that stay honest."""

from __future__ import annotations

from collections.abc import Sequence


def holm(p_values: Sequence[float]) -> tuple[float, ...]:
    """Return adjusted p-values, in the order of those given.

    Rejecting all hypotheses whose adjusted value is at most alpha rejects no true one with probability 1 - alpha at
    least, however the tests depend on each other. The i-th smallest of m values becomes the largest (m - j + 1) p_j
    among j = 1 … i, and 1 at most.

    Source: Holm, A simple sequentially rejective multiple test procedure, Scandinavian Journal of Statistics 6
    (1979), section 3.

    Raises:
        ValueError: One is not within 0 and 1.
    """
    for number, p in enumerate(p_values):
        if not 0 <= p <= 1:
            raise ValueError(f"p-value {number} is {p}; expected 0 to 1")
    order = sorted(range(len(p_values)), key=p_values.__getitem__)
    adjusted = [1.0] * len(order)
    least = 0.0
    for rank, number in enumerate(order):
        least = max(least, min(1.0, (len(order) - rank) * p_values[number]))
        adjusted[number] = least
    return tuple(adjusted)
