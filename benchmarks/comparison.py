"""How often an anytime-valid comparison is wrong, looked at after each pair, and how many runs it takes.

Against Welch's test with a number of runs that is fixed beforehand.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from scipy import stats

from benchmarks._report import Row
from hmrsim.experiments.statistics import Criterion, verdict

if TYPE_CHECKING:
    from numpy.typing import NDArray

QUICK: dict[str, Any] = {"experiments": 200, "powered": 100, "effects": (0.5,)}

_ALPHA: Final = 0.05
_POWER: Final = 0.9
_RATIO: Final = 1 / 3
_SEED: Final = 7
_FEW: Final = 20
"""Pairs of a t test that is looked at once."""


@dataclass(frozen=True)
class _Measure:
    """How a measure is distributed.

    Attributes:
        name: As people call it.
        of: Makes it of standard normal numbers.
        stddev: Its standard deviation, which differences are told in.
        yes_no: Whether it is 0 or 1.
    """

    name: str
    of: Callable[[NDArray[np.float64]], NDArray[np.float64]]
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


def _lognormal(stddev: float, z: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return lognormal numbers whose mean is 0."""
    return np.asarray(np.exp(stddev * z) - math.exp(stddev**2 / 2))


def _skewed(chance: np.random.Generator, shape: tuple[int, int]) -> dict[str, NDArray[np.float64]]:
    """Return differences whose mean is 0, by the distributions of A and B."""
    a, own, b = chance.standard_normal((3, *shape))
    return {
        "normal and lognormal (0.5)": _lognormal(0.5, 0.8 * a + 0.6 * own) - 0.6 * a,
        "normal and exponential": chance.standard_exponential(shape) - 1 - own,
        "constant and exponential": chance.standard_exponential(shape) - 1,
        "constant and lognormal (1)": _lognormal(1.0, b),
    }


def _yes(share: float) -> _Measure:
    """Return a measure that is 1 with some probability."""
    limit = stats.norm.ppf(share)
    return _Measure(
        f"yes in {share:.0%}", lambda z: (z < limit).astype(float), math.sqrt(share * (1 - share)), yes_no=True
    )


def run(
    *,
    experiments: int = 10_000,
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
        found = sum(_decided(one, two, measure) is not None for one, two in zip(a, b, strict=True))
        share = 100 * found / experiments
        rows.append(Row(f"A against A, {measure.name}: false", share, "% of experiments", at_most=100 * _ALPHA))
    a, b = _runs(chance, _REAL[0], _REAL[0], (experiments, pairs), rho)
    rows.append(Row("A against A, normal: a t test at each look", 100 * _peeked(b - a), "% of experiments"))
    for name, differences in _skewed(chance, (experiments, pairs)).items():
        found = sum(_decided(np.zeros(pairs), row, _REAL[0]) is not None for row in differences)
        rows.append(Row(f"equal means, {name}: false", 100 * found / experiments, "% of experiments"))
        once = 100 * float((stats.ttest_1samp(differences[:, :_FEW], 0, axis=1).pvalue < _ALPHA).mean())
        rows.append(Row(f"equal means, {name}: a t test of {_FEW} pairs, once", once, "% of experiments"))
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
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the values of A and of B, one experiment a row, one seed a column."""
    common, own = chance.standard_normal((2, *shape))
    rho = a.correlation(rho)
    return a.of(common), b.of(rho * common + math.sqrt(1 - rho**2) * own)


def _decided(a: NDArray[np.float64], b: NDArray[np.float64], measure: _Measure) -> int | None:
    """Return after how many pairs one is known to be better, by looking after each."""
    criterion = Criterion(larger_is_better=True, yes_no=measure.yes_no, alpha=_ALPHA)
    return verdict(a.tolist(), b.tolist(), criterion)[1]


def _peeked(differences: NDArray[np.float64]) -> float:
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

    Ours end at the latest after so many pairs that the power is that of Welch's test: what they take is a mean.
    """
    fixed = _welch(chance, a, b, experiments)
    first, second = _runs(chance, a, b, (experiments, fixed), rho)
    after = [_decided(one, two, a) or math.inf for one, two in zip(first, second, strict=True)]
    latest = min(float(np.quantile(after, _POWER, method="higher")), fixed)
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
