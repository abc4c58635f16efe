"""What each treatment came to: rates, means, quantiles, histograms."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Final

from hmrsim.experiments.report.model import Column, Ending, Estimate, Histogram, Treatment
from hmrsim.experiments.results.groups import interval_of, share_of
from hmrsim.experiments.results.repeats import counted
from hmrsim.experiments.statistics.libraries import arrays
from hmrsim.experiments.statistics.summaries import summary

if TYPE_CHECKING:
    from hmrsim.experiments.report.columns import Columns, Flags, Numbers
    from hmrsim.experiments.statistics.intervals import Interval

_FEWEST_BINS: Final = 8
_MOST_BINS: Final = 40


def estimate_of(interval: Interval) -> Estimate:
    """Return an interval as a value of the report."""
    return Estimate(estimate=interval.estimate, low=interval.low, high=interval.high, n=interval.n)


def treatments_of(columns: Columns) -> tuple[Treatment, ...]:
    """Return all treatments, also those without a run."""
    return tuple(_treatment(columns, number) for number in range(len(columns.treatments)))


def endings_of(columns: Columns) -> tuple[Ending, ...]:
    """Return how the runs ended."""
    np = arrays()
    size = len(columns.endings)
    counts = np.bincount(columns.ending, minlength=size).tolist()
    successes = np.bincount(columns.ending, columns.success, size).tolist()
    found = [
        Ending(name=name, runs=count, success=good > 0)
        for name, count, good in zip(columns.endings, counts, successes, strict=True)
    ]
    return tuple(sorted(found, key=lambda ending: (-ending.runs, ending.name)))


def _treatment(columns: Columns, number: int) -> Treatment:
    chosen = columns.treatment == number
    endings = arrays().bincount(columns.ending[chosen], minlength=len(columns.endings))
    runs, successes = int(chosen.sum()), int(columns.success[chosen].sum())
    return Treatment(
        name=columns.treatments[number],
        runs=runs,
        success=estimate_of(share_of(successes, runs, _count(columns, chosen))),
        endings={name: int(count) for name, count in zip(columns.endings, endings, strict=True) if count},
        measures={name: _column(columns, chosen, values) for name, values in columns.measures.items()},
    )


def _count(columns: Columns, chosen: Flags) -> int:
    """Return as how many runs some count."""
    return counted(int(chosen.sum()), float(columns.squares[chosen].sum()))


def _column(columns: Columns, chosen: Flags, values: Numbers) -> Column:
    there = chosen & ~arrays().isnan(values)
    known = values[there].tolist()
    found = summary(known)
    return Column(
        mean=estimate_of(interval_of(known, _count(columns, there))),
        missing=int(chosen.sum()) - len(known),
        failed=len(known) - int(columns.success[there].sum()),
        stddev=found.stddev,
        least=found.least,
        median=found.quantiles.get(0.5),
        p95=found.quantiles.get(0.95),
        most=found.most,
    )


def histograms_of(columns: Columns) -> dict[str, Histogram]:
    """Return the histograms of the measures that have values; those of all treatments have the same edges."""
    np = arrays()
    found = {}
    for name, values in columns.measures.items():
        known = values[~np.isnan(values)]
        if len(known):
            edges = _edges(known)
            by_treatment = {
                treatment: tuple(np.histogram(values[columns.treatment == number], edges)[0].tolist())
                for number, treatment in enumerate(columns.treatments)
            }
            found[name] = Histogram(edges=tuple(edges), counts=by_treatment)
    return found


def _edges(values: Numbers) -> list[float]:
    """Return the edges of bins: one for each whole number if they are few, else by the rule of Freedman and Diaconis.

    Source: Freedman and Diaconis, On the histogram as a density estimator: L2 theory, Zeitschrift für
    Wahrscheinlichkeitstheorie und verwandte Gebiete 57 (1981): bins as wide as 2 IQR / ∛n.
    """
    np = arrays()
    least, most = float(values.min()), float(values.max())
    span = most - least
    if span < _MOST_BINS and bool((values == np.round(values)).all()):
        return [least - 0.5 + step for step in range(int(span) + 2)]
    if least + span / _MOST_BINS == least:
        return [least - (abs(least) or 1.0) / 2, least + (abs(least) or 1.0) / 2]
    first, third = np.quantile(values, (0.25, 0.75))
    width = 2 * float(third - first) / math.cbrt(len(values))
    bins = math.ceil(min(_MOST_BINS, max(_FEWEST_BINS, span / width if width > 0 else 0)))
    edges: list[float] = np.linspace(least, most, bins + 1).tolist()
    return edges


def with_success(columns: Columns) -> Mapping[str, Numbers]:
    """Return the values of all measures, of which success is the first."""
    return {"success": columns.success, **columns.measures}
