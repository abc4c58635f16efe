"""The error rate of an anytime-valid comparison that is checked after each pair, and the number of runs it takes.

The baseline is Welch's test with a number of runs that is fixed beforehand.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import numpy as np
from scipy import stats

from benchmarks._report import Row
from hmrsim.experiments.statistics.confidence_sequences import first_above

if TYPE_CHECKING:
    from numpy.typing import NDArray

QUICK: dict[str, Any] = {"experiments": 200, "powered": 100, "effects": (0.5,)}

_Numbers: TypeAlias = "NDArray[np.float64]"

_ALPHA: Final = 0.05
_POWER: Final = 0.9
_RATIO: Final = 1 / 3
_SEED: Final = 7
_FEW: Final = 30
"""Pairs of a t test that is looked at once; ours are looked at from there on."""
_SKEWED: Final = 10.0
"""Percent of false verdicts, at most, where differences are skewed."""


@dataclass(frozen=True)
class _Measure:
    """The distribution of a measure.

    Attributes:
        name: The name of the distribution.
        of: Computes values from standard normal numbers.
        stddev: The standard deviation, which is the unit of differences.
        yes_no: Whether it is 0 or 1.
    """

    name: str
    of: Callable[[_Numbers], _Numbers]
    stddev: float
    yes_no: bool = False

    def correlation(self, rho: float) -> float:
        """Return the correlation of normal numbers that gives the measure's values about this one."""
        return math.sin(math.pi / 2 * rho) if self.yes_no else rho


_REAL: Final = (
    _Measure("normal", np.copy, 1.0),
    _Measure("lognormal", np.exp, math.sqrt((math.e - 1) * math.e)),
    _Measure("t with 3 degrees", lambda z: np.asarray(stats.t.ppf(stats.norm.cdf(z), 3)), math.sqrt(3)),
)


def _yes(share: float) -> _Measure:
    """Return a measure that is 1 with some probability."""
    limit = stats.norm.ppf(share)
    return _Measure(
        f"yes in {share:.0%}", lambda z: (z < limit).astype(float), math.sqrt(share * (1 - share)), yes_no=True
    )


@dataclass(frozen=True)
class _Differences:
    """The distribution of B - A with a mean of 0, although A and B differ.

    Attributes:
        name: The names of A and B.
        of: Samples differences.
        at_most: The maximum percentage of false verdicts.
        measure: The distribution of A and B.
    """

    name: str
    of: Callable[[np.random.Generator, tuple[int, int]], _Numbers]
    at_most: float = _SKEWED
    measure: _Measure = _REAL[0]


def _lognormal(stddev: float, z: _Numbers) -> _Numbers:
    """Return lognormal numbers whose mean is 1."""
    return np.asarray(np.exp(stddev * z - stddev**2 / 2))


def _common(chance: np.random.Generator, shape: tuple[int, int]) -> _Numbers:
    z = chance.standard_normal(shape)
    return _lognormal(1.0, z) - _lognormal(0.7, z)


def _unrelated(chance: np.random.Generator, shape: tuple[int, int]) -> _Numbers:
    a, b = chance.standard_normal((2, *shape))
    return _lognormal(1.5, b) - _lognormal(0.5, a)


def _levels(chance: np.random.Generator, shape: tuple[int, int]) -> _Numbers:
    """Return differences of three levels, each of which each replication has once, in any order."""
    experiments, pairs = shape
    means = np.tile([-1.0, 0.0, 1.0], (experiments, -(-pairs // 3), 1))
    return chance.permuted(means, axis=2).reshape(experiments, -1)[:, :pairs] + chance.normal(0, 0.5, shape)


def _yes_no_levels(chance: np.random.Generator, shape: tuple[int, int]) -> _Numbers:
    """Return differences of sixty levels, at half of which A always succeeds and B never, at the others B."""
    experiments, pairs = shape
    signs = np.tile(np.repeat([-1.0, 1.0], 30), (experiments, -(-pairs // 60), 1))
    return chance.permuted(signs, axis=2).reshape(experiments, -1)[:, :pairs]


def _rare(share: float) -> _Differences:
    """Return differences of 1 to one side, but for a few seeds that make up for all others."""

    def of(chance: np.random.Generator, shape: tuple[int, int]) -> _Numbers:
        return np.where(chance.random(shape) < share, 1 / share - 1, -1.0) + chance.normal(0, 0.1, shape)

    unseen = 100 * (1 - share) ** _FEW
    return _Differences(f"all but {share:.0%} of seeds better, on balance equal", of, unseen + 100 * _ALPHA)


_SAME_MEANS: Final = (
    _Differences("t with 3 degrees, and twice as wide", lambda chance, n: chance.standard_t(3, n), 100 * _ALPHA),
    _Differences("three levels, better at one, worse at one", _levels, 100 * _ALPHA),
    _Differences("sixty levels, A succeeds at half, B at the others", _yes_no_levels, 100 * _ALPHA, _yes(0.5)),
    _Differences("normal and exponential", lambda chance, n: chance.exponential(1, n) - chance.normal(1, 1, n)),
    _Differences("uniform and 0 or 1", lambda chance, n: chance.binomial(1, 0.1, n) - chance.uniform(0, 0.2, n)),
    _Differences("uniform and beta (0.5, 4.5)", lambda chance, n: chance.beta(0.5, 4.5, n) - chance.uniform(0, 0.2, n)),
    _Differences("constant and exponential", lambda chance, n: chance.exponential(1, n) - 1),
    _Differences("constant and gamma (0.3)", lambda chance, n: chance.gamma(0.3, 1, n) - 0.3),
    _Differences("constant and Pareto (2.5)", lambda chance, n: chance.pareto(2.5, n) - 1 / 1.5),
    _Differences("constant and lognormal (0.5)", lambda chance, n: _lognormal(0.5, chance.standard_normal(n)) - 1),
    _Differences("constant and lognormal (1)", lambda chance, n: _lognormal(1.0, chance.standard_normal(n)) - 1),
    _Differences("constant and lognormal (1.5)", lambda chance, n: _lognormal(1.5, chance.standard_normal(n)) - 1),
    _Differences("lognormal (0.7) and (1), common seeds", _common),
    _Differences("lognormal (0.5) and (1.5), independent", _unrelated),
    _rare(0.1),
    _rare(0.05),
    _rare(0.02),
)


def run(
    *,
    experiments: int = 5_000,
    pairs: int = 200,
    powered: int = 2000,
    effects: Sequence[float] = (0.2, 0.5, 1.0),
    rho: float = 0.8,
) -> list[Row]:
    """Return false verdicts of A against A, and runs until B is known to be better.

    Args:
        experiments: How many experiments of A against A there are for each measure.
        pairs: How long each of them is.
        powered: How many experiments there are for each difference.
        effects: By how much B is better, in standard deviations of the measure.
        rho: The correlation of two runs under one seed; that of normal numbers which lognormal ones and others are
            made of, and about that of the values for yes and no.
    """
    chance = np.random.default_rng(_SEED)
    rows = []
    for measure in (*_REAL, _yes(0.5), _yes(0.95)):
        a, b = _runs(chance, measure, measure, (experiments, pairs), rho)
        found = sum(_decided(row, measure) is not None for row in b - a)
        share = 100 * found / experiments
        rows.append(Row(f"A against A, {measure.name}: false", share, "% of experiments", at_most=100 * _ALPHA))
    a, b = _runs(chance, _REAL[0], _REAL[0], (experiments, pairs), rho)
    rows.append(Row("A against A, normal: a t test at each look", 100 * _peeked(b - a), "% of experiments"))
    for each in _SAME_MEANS:
        differences = each.of(chance, (experiments, pairs))
        found = sum(_decided(row, each.measure) is not None for row in differences)
        share = 100 * found / experiments
        rows.append(Row(f"equal means, {each.name}: false", share, "% of experiments", at_most=each.at_most))
        once = 100 * float((stats.ttest_1samp(differences[:, :_FEW], 0, axis=1).pvalue < _ALPHA).mean())
        rows.append(Row(f"equal means, {each.name}: a t test of {_FEW} pairs, once", once, "% of experiments"))
    for effect in effects:
        for measure in _REAL:
            better = _moved(measure, effect * measure.stddev)
            rows += _until_known(chance, measure, better, f"{measure.name}, {effect:g} stddev", powered, rho)
        half, more = _yes(0.5), _yes(0.5 + effect / 2)
        if effect < 1:
            rows += _until_known(chance, half, more, f"{half.name} or {0.5 + effect / 2:.0%}", powered, rho)
    return rows


def _moved(measure: _Measure, by: float) -> _Measure:
    return _Measure(measure.name, lambda z: measure.of(z) + by, measure.stddev)


def _runs(
    chance: np.random.Generator, a: _Measure, b: _Measure, shape: tuple[int, int], rho: float
) -> tuple[_Numbers, _Numbers]:
    """Return the values of A and of B, one experiment a row, one seed a column."""
    common, own = chance.standard_normal((2, *shape))
    rho = a.correlation(rho)
    return a.of(common), b.of(rho * common + math.sqrt(1 - rho**2) * own)


def _decided(differences: _Numbers, measure: _Measure) -> int | None:
    """Return after how many pairs one is first said to be better, by looking after each, whatever later ones say."""
    given = (first_above((way * differences).tolist(), 0.0, _ALPHA, yes_no=measure.yes_no) for way in (1, -1))
    return min((after for after in given if after is not None), default=None)


def _peeked(differences: _Numbers) -> float:
    """Return the share of experiments in which Student's t test is significant at some look, from the third pair on."""
    n = np.arange(1, differences.shape[1] + 1)
    means = differences.cumsum(axis=1) / n
    variances = ((differences**2).cumsum(axis=1) - n * means**2)[:, 2:] / (n[2:] - 1)
    statistics = np.abs(means[:, 2:]) / np.sqrt(variances / n[2:])
    return float((statistics > stats.t.isf(_ALPHA / 2, n[2:] - 1)).any(axis=1).mean())


def _until_known(
    chance: np.random.Generator, a: _Measure, b: _Measure, name: str, experiments: int, rho: float
) -> list[Row]:
    """Return how many runs both take to find a difference with the same power.

    Ours end at the latest after so many pairs that the power is that of Welch's test: what they take is a mean. No
    experiment has more pairs than that test takes, or than three times those before the first look.
    """
    fixed = _welch(chance, a, b, experiments)
    pairs = max(fixed, 3 * _FEW)
    first, second = _runs(chance, a, b, (experiments, pairs), rho)
    after = [_decided(row, a) or math.inf for row in second - first]
    latest = min(float(np.quantile(after, _POWER, method="higher")), pairs)
    mean = 2 * float(np.minimum(after, latest).mean())
    return [
        Row(f"{name}: runs until a verdict", mean, "runs", mean / (2 * fixed), ratio_at_most=_RATIO),
        Row(f"{name}: runs after which {_POWER:.0%} have one", 2 * latest, "runs", latest / fixed),
        Row(f"{name}: Welch at a power of {_POWER:.0%}", 2.0 * fixed, "runs", 1.0),
    ]


def _welch(chance: np.random.Generator, a: _Measure, b: _Measure, experiments: int) -> int:
    """Return the least number of runs of each treatment with which Welch's test finds the difference often enough."""

    def power(n: int) -> float:
        first, second = _runs(chance, a, b, (experiments, n), 0.0)
        # Few yeses and noes may have no spread at all: there is no statistic then, and nothing is found.
        with np.errstate(all="ignore"), warnings.catch_warnings(action="ignore", category=RuntimeWarning):
            return float((stats.ttest_ind(first, second, axis=1, equal_var=False).pvalue < _ALPHA).mean())

    high = 4
    while power(high) < _POWER:
        high *= 2
    low = high // 2
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if power(middle) >= _POWER else (middle, high)
    return high
