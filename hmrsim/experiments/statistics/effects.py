"""Effects of factors, interactions of two factors, and differences of two treatments."""

from __future__ import annotations

import itertools
import math
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass

from hmrsim.experiments.statistics.intervals import CONFIDENCE, Interval, checked_share, mean_interval
from hmrsim.experiments.statistics.summaries import Moments, distributions, moments, pairs


@dataclass(frozen=True)
class LevelEffect:
    """The effect of one level of a factor.

    Attributes:
        factor: Its name.
        level: One of its levels.
        mean: The mean of the runs at this level, with its interval.
        effect: The mean less the grand mean.
    """

    factor: str
    level: Hashable
    mean: Interval
    effect: float


@dataclass(frozen=True)
class Interaction:
    """The interaction of two levels, beyond the effect of each.

    Attributes:
        factors: The names of the factors.
        levels: A level of each factor.
        mean: The mean of the runs at both levels, with its interval.
        effect: The mean less the sum of the grand mean and both main effects.
    """

    factors: tuple[str, str]
    levels: tuple[Hashable, Hashable]
    mean: Interval
    effect: float


@dataclass(frozen=True)
class Difference:
    """The difference of two treatments, B - A.

    Attributes:
        interval: The mean difference, with its interval; *n* is the number of pairs, or of all runs if unpaired.
        statistic: Student's t; infinite for differences that are all equal and not 0; None for too few runs.
        degrees: Degrees of freedom; None for too few runs.
        p: The two-sided p-value of no difference; None for too few runs.
    """

    interval: Interval
    statistic: float | None
    degrees: float | None
    p: float | None


def main_effects(
    runs: Sequence[Mapping[str, Hashable]], values: Sequence[float], *, confidence: float = CONFIDENCE
) -> tuple[LevelEffect, ...]:
    """Return the effect of each level of each factor: the mean of its runs, less the mean of all runs.

    In a balanced design, these are the least-squares estimates. In an unbalanced one, a level's mean contains effects
    of the other factors. The intervals are Student's, over the runs of the level, and include the spread that other
    factors cause.

    Source: Montgomery, Design and Analysis of Experiments, 8th edition (2012), sections 3.3.3 and 5.3.4
    (estimates of the effects model).

    Args:
        runs: The level of each factor, for each run; all have the same factors.
        values: The measure, for each run.
        confidence: The confidence of the intervals.

    Returns:
        The effects in order of factors and of the first run of each level.

    Raises:
        ValueError: There are not as many values as runs, or runs have different factors.
    """
    grand, factors = _grand_mean(runs, values)
    found = []
    for factor in factors:
        for (level,), group in _groups(runs, values, (factor,)).items():
            mean = mean_interval(group, confidence=confidence)
            found.append(LevelEffect(factor, level, mean, (mean.estimate or 0.0) - grand))
    return tuple(found)


def interactions(
    runs: Sequence[Mapping[str, Hashable]], values: Sequence[float], *, confidence: float = CONFIDENCE
) -> tuple[Interaction, ...]:
    """Return the interaction of each two levels: the mean of their runs, less both levels' means, plus the grand mean.

    Only levels that occur together are returned. The note on unbalanced designs in `main_effects` applies here.

    Source: Montgomery, Design and Analysis of Experiments, 8th edition (2012), section 5.3.4.

    Raises:
        ValueError: As for `main_effects`.
    """
    grand, factors = _grand_mean(runs, values)
    alone = {(one.factor, one.level): one.effect for one in main_effects(runs, values, confidence=confidence)}
    found = []
    for first, second in itertools.combinations(factors, 2):
        for (one, other), group in _groups(runs, values, (first, second)).items():
            mean = mean_interval(group, confidence=confidence)
            expected = grand + alone[first, one] + alone[second, other]
            found.append(Interaction((first, second), (one, other), mean, (mean.estimate or 0.0) - expected))
    return tuple(found)


def paired_difference(a: Sequence[float], b: Sequence[float], *, confidence: float = CONFIDENCE) -> Difference:
    """Return the difference of two treatments that ran under the same seeds, by Student's t over the differences.

    Fix the number of pairs beforehand; only `verdicts.compare` may be called after each pair.

    Source: Student, The probable error of a mean, Biometrika 6 (1908); Law, Simulation Modeling and Analysis, 5th
    edition (2015), section 10.2.1 (the paired-t confidence interval).

    Raises:
        ValueError: A and B have different numbers of values, or a value is not finite.
    """
    first, second = pairs(a, b)
    differences = [two - one for one, two in zip(first, second, strict=True)]
    found = moments(differences)
    interval = mean_interval(differences, confidence=confidence)
    if found.mean is None or found.stddev is None:
        return Difference(interval, None, None, None)
    return _difference(interval, found.mean, found.stddev / math.sqrt(found.n), found.n - 1)


def unpaired_difference(a: Sequence[float], b: Sequence[float], *, confidence: float = CONFIDENCE) -> Difference:
    """Return the difference of two treatments that ran under different seeds, by Welch's t.

    Source: Welch, The generalization of Student's problem when several different population variances are involved,
    Biometrika 34 (1947); degrees of freedom by Satterthwaite, Biometrics Bulletin 2 (1946).

    Raises:
        ValueError: A value is not finite.
    """
    alpha = 1 - checked_share(confidence, "confidence")
    one, two = moments(a), moments(b)
    n = one.n + two.n
    estimate = None if one.mean is None or two.mean is None else two.mean - one.mean
    if estimate is None or one.stddev is None or two.stddev is None:
        return Difference(Interval(estimate, None, None, n, confidence), None, None, None)
    error = math.hypot(one.stddev / math.sqrt(one.n), two.stddev / math.sqrt(two.n))
    degrees = _satterthwaite(one, two, error)
    half = float(distributions().t.isf(alpha / 2, degrees)) * error
    return _difference(Interval(estimate, estimate - half, estimate + half, n, confidence), estimate, error, degrees)


def _satterthwaite(one: Moments, two: Moments, error: float) -> float:
    """Return the degrees of freedom; those of the pooled variance if there is none."""
    if error == 0:
        return one.n + two.n - 2
    shares = [((part.stddev or 0.0) / error) ** 2 / part.n for part in (one, two)]
    return 1 / math.fsum(share**2 / (part.n - 1) for share, part in zip(shares, (one, two), strict=True))


def _difference(interval: Interval, mean: float, error: float, degrees: float) -> Difference:
    certain = math.copysign(math.inf, mean) if mean else 0.0
    statistic = mean / error if error else certain
    return Difference(interval, statistic, degrees, float(2 * distributions().t.sf(abs(statistic), degrees)))


def _grand_mean(runs: Sequence[Mapping[str, Hashable]], values: Sequence[float]) -> tuple[float, tuple[str, ...]]:
    """Return the mean of all runs, and the factors."""
    if len(runs) != len(values):
        raise ValueError(f"{len(runs)} runs and {len(values)} values; expected one value for each run")
    factors = tuple(runs[0]) if runs else ()
    for number, run in enumerate(runs):
        if run.keys() != set(factors):
            raise ValueError(f"run {number} has the factors {', '.join(run)}; expected {', '.join(factors)}")
    return moments(values).mean or 0.0, factors


def _groups(
    runs: Sequence[Mapping[str, Hashable]], values: Sequence[float], factors: Sequence[str]
) -> dict[tuple[Hashable, ...], list[float]]:
    """Return the values by the levels of some factors, in order of the first run of each."""
    groups: dict[tuple[Hashable, ...], list[float]] = {}
    for run, value in zip(runs, values, strict=True):
        groups.setdefault(tuple(run[factor] for factor in factors), []).append(value)
    return groups
