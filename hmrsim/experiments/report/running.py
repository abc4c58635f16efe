"""Means over the first replications, the first two, and so on, by which one sees whether there were enough."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Final

from hmrsim.experiments.comparing import SUCCESS
from hmrsim.experiments.report.model import Estimate, Point
from hmrsim.experiments.report.treatments import estimate_of, with_success
from hmrsim.experiments.statistics.intervals import CONFIDENCE, proportion_interval
from hmrsim.experiments.statistics.libraries import arrays, distributions

if TYPE_CHECKING:
    from hmrsim.experiments.report.columns import Codes, Columns, Numbers

_MAX_POINTS: Final = 120


def running_of(columns: Columns) -> dict[str, dict[str, tuple[Point, ...]]]:
    """Return the running means of each measure that has values, by treatment; nothing of a single replication."""
    if not len(columns) or not columns.replication.any():
        return {}
    np = arrays()
    found = {}
    for name, values in with_success(columns).items():
        known = ~np.isnan(values)
        if known.any():
            found[name] = {
                treatment: tuple(_points(values[chosen], columns.replication[chosen], shares=name == SUCCESS))
                for number, treatment in enumerate(columns.treatments)
                if (chosen := known & (columns.treatment == number)).any()
            }
    return found


def _points(values: Numbers, replications: Codes, *, shares: bool) -> Iterator[Point]:
    """Yield the means with their intervals; they are Student's, or Wilson's of shares."""
    np = arrays()
    ends = np.flatnonzero(np.diff(replications, append=replications[-1] + 1))
    if len(ends) > _MAX_POINTS:
        ends = ends[np.unique(np.linspace(0, len(ends) - 1, _MAX_POINTS).round().astype(int))]
    counts = ends + 1
    # Sums of squares are those of distances from the mean of all, so that they lose no digits.
    middle = float(values.mean())
    sums = np.cumsum(values - middle)[ends]
    squares = np.cumsum((values - middle) ** 2)[ends]
    deviations = np.sqrt(np.maximum(squares - sums**2 / counts, 0.0) / np.maximum(counts - 1, 1))
    quantiles = distributions().t.isf((1 - CONFIDENCE) / 2, np.maximum(counts - 1, 1))
    halves = quantiles * deviations / np.sqrt(counts)
    for end, n, total, half in zip(ends.tolist(), counts.tolist(), sums.tolist(), halves.tolist(), strict=True):
        mean = middle + total / n
        bounds = (mean - half, mean + half) if n > 1 else (None, None)
        said = Estimate(estimate=mean, low=bounds[0], high=bounds[1], n=n)
        share = estimate_of(proportion_interval(round(mean * n), n)) if shares else said
        yield Point(replications=int(replications[end]) + 1, mean=share)
