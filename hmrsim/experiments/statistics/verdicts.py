"""Verdicts on whether treatment B is better than A, which you can request after every pair of runs.

A verdict stands once it is given: however often you look, the probability of a false one is limited.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal, NamedTuple

from hmrsim.experiments.statistics.confidence_sequences import confidence_sequence, first_above
from hmrsim.experiments.statistics.intervals import Interval, checked_share
from hmrsim.experiments.statistics.summaries import pairs

Verdict = Literal["better", "worse", "equivalent", "undecided"]
"""The verdict of a comparison on treatment B."""

BETTER: Final = "better"
"""Better by more than the margin."""
WORSE: Final = "worse"
"""Worse by more than the margin."""
EQUIVALENT: Final = "equivalent"
"""The difference is within the margin."""
UNDECIDED: Final = "undecided"
"""There are too few runs for a verdict."""

_MOST_DIFFERING: Final = 0.05
"""The share of seeds whose values may differ although all pairs so far are equal."""


@dataclass(frozen=True)
class Criterion:
    """The criterion for a measure.

    Attributes:
        larger_is_better: True for a number of orders, False for a time, for example.
        margin: Differences of the means below this do not matter; None if all differences matter.
        relative: Whether the margin is a share of A's mean, such as 0.05; then no value of A may be negative.
        yes_no: Whether all values are 0 or 1, so that the means are shares. None derives that from the values: all are
            0 or 1, both occur, and the margin is relative or below 1.
        alpha: The probability of a false verdict, however often you look, as far as `confidence_sequence` holds.
    """

    larger_is_better: bool
    margin: float | None = None
    relative: bool = False
    yes_no: bool | None = None
    alpha: float = 0.05

    def __post_init__(self) -> None:
        """Raise ValueError if a value is out of range."""
        checked_share(self.alpha, "alpha")
        if self.margin is not None and not 0 < self.margin < math.inf:
            raise ValueError(f"margin must be positive, got {self.margin}")
        if self.yes_no and self._is_wide:
            raise ValueError(f"the margin of yes and no is a difference of shares: below 1, got {self.margin:g}")

    @property
    def _is_wide(self) -> bool:
        """True if shares can't differ by more than the margin."""
        return self.margin is not None and not self.relative and self.margin >= 1

    def settled(self, first: Sequence[float], second: Sequence[float]) -> Criterion:
        """Return the criterion with *yes_no* derived from the values if it is None."""
        if self.yes_no is not None:
            return self
        return replace(self, yes_no={*first, *second} == {0, 1} and not self._is_wide)


@dataclass(frozen=True)
class Comparison:
    """The comparison of B with A: the difference B - A and the verdicts.

    Attributes:
        verdict: ``better`` or ``worse`` if B's mean is better or worse, however little; ``equivalent`` if the means
            differ by less than the margin; ``undecided`` if neither is known yet.
        decided_after: The number of pairs after which the verdict was given; None while it is undecided.
        difference: The mean of B - A, with a confidence sequence.
        differing: The number of pairs whose two values are not equal.
        withdrawn: Earlier verdicts that all pairs together contradict, in order.
    """

    verdict: Verdict
    decided_after: int | None
    difference: Interval
    differing: int
    withdrawn: tuple[Verdict, ...] = ()


def verdict(a: Sequence[float], b: Sequence[float], criterion: Criterion) -> tuple[Verdict, int | None]:
    """Return the first verdict that a look after each pair gives, and the number of pairs before it.

    The probability that any look gives a false verdict is at most *alpha*, where `confidence_sequence` holds. The first
    verdict stands, unless all pairs together contradict it, because their mean is on the other side of 0 or beyond the
    margin. Then it is withdrawn, and the next verdict that all pairs together do not contradict is given, if there is
    one. B can be both better and equivalent, if it is better by less than the margin. The verdict that is known first
    is given, and ``equivalent`` if both become known at once.

    If real numbers are equal in all pairs so far, they do not show how large a difference could be. With a margin, they
    are equivalent as soon as it is excluded, at level alpha, that they differ for 5 % of all seeds or more: after 59
    pairs for alpha = 0.05, since (1 - 0.05)ⁿ ≤ alpha. Values of 0 and 1 need no such rule.

    A relative margin is compared with the true mean of A, not with its estimate: B - (1 - margin) A has to be above 0,
    and B - (1 + margin) A below 0.

    Source: Schuirmann, A comparison of the two one-sided tests procedure and the power approach for assessing the
    equivalence of average bioavailability, Journal of Pharmacokinetics and Biopharmaceutics 15 (1987).

    Raises:
        ValueError: A and B have different numbers of values, or a value is not finite, not 0 or 1 for yes and no, or
            negative in A for a relative margin.
    """
    given, after, _ = _verdict(*_checked(a, b, criterion))
    return given, after


def compare(a: Sequence[float], b: Sequence[float], criterion: Criterion) -> Comparison:
    """Return the verdict and the difference between B and A.

    Args:
        a: A measure of the runs of A, in the order of their seeds.
        b: The measure of the runs of B, under the same seeds.
        criterion: The criterion.

    Raises:
        ValueError: As for `verdict`.
    """
    first, second, settled = _checked(a, b, criterion)
    given, after, withdrawn = _verdict(first, second, settled)
    differences = [two - one for one, two in zip(first, second, strict=True)]
    interval = confidence_sequence(differences, yes_no=bool(settled.yes_no), confidence=1 - criterion.alpha)
    differing = sum(difference != 0 for difference in differences)
    return Comparison(given, after, interval, differing, withdrawn)


def compare_all(
    measures: Mapping[str, tuple[Sequence[float], Sequence[float]]], criteria: Mapping[str, Criterion], *, alpha: float
) -> dict[str, Comparison]:
    """Return a comparison for each measure, such that all verdicts together are true with probability 1 - alpha.

    Each comparison has alpha divided by the number of measures (Bonferroni), and the alpha of its criterion is ignored.
    Holm's stepwise procedure would allow later comparisons more, but it does not apply here: it requires that a
    rejected hypothesis can't be rejected wrongly, while a measure has several verdicts of which at least one is false.
    It does apply to the p-values of `effects`.

    Args:
        measures: The values of A and of B, by the name of the measure.
        criteria: The criteria, by the same names.
        alpha: The probability that any verdict is false.

    Raises:
        ValueError: As for `verdict`, or names differ.
    """
    if measures.keys() != criteria.keys():
        raise ValueError(f"measures {', '.join(measures)}; criteria of {', '.join(criteria)}")
    return {
        name: compare(a, b, replace(criteria[name], alpha=alpha / len(measures))) for name, (a, b) in measures.items()
    }


class _Claim(NamedTuple):
    """A verdict that the first pairs give.

    Attributes:
        after: The number of these pairs.
        rank: The order of verdicts that are given after the same pair.
        holds: Whether all pairs together do not contradict it.
    """

    after: int
    rank: int
    verdict: Verdict
    holds: bool


def _verdict(
    first: Sequence[float], second: Sequence[float], criterion: Criterion
) -> tuple[Verdict, int | None, tuple[Verdict, ...]]:
    """Return the verdict, the number of pairs after which it was given, and the verdicts withdrawn before."""
    claims = sorted(_claims(first, second, criterion))
    withdrawn = tuple(claim.verdict for claim in itertools.takewhile(lambda claim: not claim.holds, claims))
    if len(withdrawn) == len(claims):
        return UNDECIDED, None, withdrawn
    standing = claims[len(withdrawn)]
    return standing.verdict, standing.after, withdrawn


def _claims(first: Sequence[float], second: Sequence[float], criterion: Criterion) -> Iterator[_Claim]:
    """Yield each verdict that the first pairs give, independently of the others."""
    differences = [two - one for one, two in zip(first, second, strict=True)]
    upwards = 1 if criterion.larger_is_better else -1
    directions: tuple[tuple[int, Verdict], ...] = ((upwards, BETTER), (-upwards, WORSE))
    for direction, verdict_there in directions:
        side = [direction * difference for difference in differences]
        after = first_above(side, 0.0, criterion.alpha, yes_no=bool(criterion.yes_no))
        if after is not None:
            yield _Claim(after, 1, verdict_there, math.fsum(side) >= 0)
    if criterion.margin is None:
        return
    low, high, value = differences, [-difference for difference in differences], -criterion.margin
    if criterion.relative:
        low = [two - (1 - criterion.margin) * one for one, two in zip(first, second, strict=True)]
        high = [(1 + criterion.margin) * one - two for one, two in zip(first, second, strict=True)]
        value = 0.0
    known = [first_above(side, value, criterion.alpha, yes_no=bool(criterion.yes_no)) for side in (low, high)]
    after = None if None in known else max(one for one in known if one is not None)
    if not criterion.yes_no:
        after = _unless_identical(first, second, after, criterion.alpha)
    if after is not None:
        holds = all(math.fsum(side) >= value * len(side) for side in (low, high))
        yield _Claim(after, 0, EQUIVALENT, holds)


def _unless_identical(first: Sequence[float], second: Sequence[float], after: int | None, alpha: float) -> int | None:
    """Return the number of pairs after which real numbers are known to be equivalent.

    The confidence bounds show it after *after* pairs, but not before a pair differs. Without a difference, enough equal
    pairs show that only few pairs can differ.
    """
    enough = math.ceil(math.log(alpha) / math.log1p(-_MOST_DIFFERING))
    if len(first) >= enough and first[:enough] == second[:enough]:
        return enough
    differs = (n for n, (one, two) in enumerate(zip(first, second, strict=True), 1) if one != two)
    earliest = next(differs, None)
    return None if after is None or earliest is None else max(after, earliest)


def _checked(
    a: Sequence[float], b: Sequence[float], criterion: Criterion
) -> tuple[Sequence[float], Sequence[float], Criterion]:
    """Return the values after checking them, and the criterion with *yes_no* derived from them."""
    first, second = pairs(a, b)
    if criterion.yes_no:
        for value in (*first, *second):
            if value not in (0, 1):
                raise ValueError(f"a value is {value:g}; expected 0 or 1 for yes and no")
    if criterion.relative and criterion.margin is not None and min(first, default=0) < 0:
        raise ValueError(f"a value of A is {min(first):g}; a relative margin is for measures that are not negative")
    return first, second, criterion.settled(first, second)


def holm(p_values: Sequence[float]) -> tuple[float, ...]:
    """Return the adjusted p-values, in the order of the given ones.

    If you reject all hypotheses whose adjusted value is at most alpha, no true one is rejected with a probability of at
    least 1 - alpha, however the tests depend on each other. The i-th smallest of m values becomes the largest
    (m - j + 1) p_j among j = 1 … i, and 1 at most.

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
