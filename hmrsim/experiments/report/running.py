"""Means over the first replications, the first two, and so on, by which one sees whether there were enough."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Final

from hmrsim.experiments.comparing import SUCCESS
from hmrsim.experiments.report.model import Estimate, Point
from hmrsim.experiments.report.treatments import estimate_of, with_success
from hmrsim.experiments.results.groups import share_of
from hmrsim.experiments.results.repeats import counted
from hmrsim.experiments.statistics.intervals import CONFIDENCE
from hmrsim.experiments.statistics.libraries import arrays, distributions

if TYPE_CHECKING:
    from hmrsim.experiments.report.columns import Columns, Flags, Numbers

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
                treatment: tuple(_points(columns, chosen, values, shares=name == SUCCESS))
                for number, treatment in enumerate(columns.treatments)
                if (chosen := known & (columns.treatment == number)).any()
            }
    return found


def _points(columns: Columns, chosen: Flags, measured: Numbers, *, shares: bool) -> Iterator[Point]:
    """Yield the means of some runs with their intervals; they are Student's, or Wilson's of shares."""
    np = arrays()
    values, replications, squares = measured[chosen], columns.replication[chosen], columns.squares[chosen]
    ends = np.flatnonzero(np.diff(replications, append=replications[-1] + 1))
    if len(ends) > _MAX_POINTS:
        ends = ends[np.unique(np.linspace(0, len(ends) - 1, _MAX_POINTS).round().astype(int))]
    counts = ends + 1
    # Sums of squares are those of distances from the mean of all, so that they lose no digits.
    middle = float(values.mean())
    sums = np.cumsum(values - middle)[ends]
    spreads = np.maximum(np.cumsum((values - middle) ** 2)[ends] - sums**2 / counts, 0.0) / counts
    numbers = [counted(*each) for each in zip(counts.tolist(), np.cumsum(squares)[ends].tolist(), strict=True)]
    degrees = np.maximum(np.asarray(numbers) - 1, 1)
    halves = distributions().t.isf((1 - CONFIDENCE) / 2, degrees) * np.sqrt(spreads / degrees)
    for end, n, total, half in zip(ends.tolist(), numbers, (sums / counts).tolist(), halves.tolist(), strict=True):
        mean = middle + total
        bounds = (mean - half, mean + half) if n > 1 else (None, None)
        said = Estimate(estimate=mean, low=bounds[0], high=bounds[1], n=n)
        share = estimate_of(share_of(round(mean * (end + 1)), end + 1, n)) if shares else said
        yield Point(replications=int(replications[end]) + 1, mean=share)
