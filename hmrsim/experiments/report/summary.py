"""The summary of an experiment's results, from its table of runs."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, Final

from hmrsim.documents.yaml_text import read_yaml
from hmrsim.experiments.contrast import SUCCESS
from hmrsim.experiments.repeats import counted, note_of
from hmrsim.experiments.report.columns import columns_of, with_success
from hmrsim.experiments.report.comparisons import comparisons_of, effects_of
from hmrsim.experiments.report.model import (
    Column,
    Ending,
    Estimate,
    Experiment,
    Histogram,
    Measure,
    Point,
    Summary,
    Treatment,
    estimate_of,
)
from hmrsim.experiments.statistics.intervals import CONFIDENCE
from hmrsim.experiments.statistics.summaries import arrays, distributions, summary
from hmrsim.experiments.table import interval_of, share_of

if TYPE_CHECKING:
    from hmrsim.experiments.report.columns import Columns, Flags, Numbers
    from hmrsim.experiments.store import Results


def summary_of(results: Results) -> Summary:
    """Return the summary of the current results; the experiment may still be running.

    Raises:
        MissingExtra: scipy is not installed.
    """
    about = results.about
    columns = columns_of(results)
    cells = about["scenarios"] * len(about["treatments"])
    replications = about["replications"]
    most = cells * replications["max"]
    least = cells * replications["min"] if replications["until"] else most
    return Summary(
        experiment=_experiment(about),
        runs=len(columns),
        least=least,
        most=most,
        successes=int(columns.success.sum()),
        notes=tuple(_notes(columns, least)),
        measures={name: Measure(**said) for name, said in _measures(about).items()},
        endings=endings_of(columns),
        treatments=tuple(_treatment(columns, number) for number in range(len(columns.treatments))),
        comparisons=comparisons_of(columns, about),
        effects=effects_of(columns),
        distributions=histograms_of(columns),
        running=running_of(columns),
        failures=columns.failures,
    )


def _measures(about: Mapping[str, Any]) -> dict[str, Mapping[str, Any]]:
    success = {"value": "", "better": "larger", "margin": None, "relative": False}
    return {SUCCESS: success, **about["measures"]}


def _experiment(about: Mapping[str, Any]) -> Experiment:
    said, _, _ = read_yaml(about["text"])
    return Experiment(
        name=about["name"],
        path=about["path"],
        text=about["text"],
        hash=about["hash"],
        seed=said.get("seed", 0),
        world=str(said["world"]),
        world_hash=about["world"],
        variant=tuple(about["variant"]),
        factors=tuple(about["factors"]),
        scenarios=about["scenarios"],
        replications=about["replications"],
        hmrsim=about["hmrsim"],
        python=about["python"],
        host=about["host"],
    )


def _notes(columns: Columns, least: int) -> Iterator[str]:
    """Yield remarks about missing or repeated runs and values."""
    if not len(columns):
        yield "No run has a result yet."
    elif len(columns) < least:
        yield (
            f"{len(columns):,} of {least:,} runs have a result: the experiment still runs, or was stopped; the same "
            "command goes on with it."
        )
    count = counted(len(columns), float(columns.squares.sum()))
    if note := note_of(len(columns), count):
        yield f"{note}."
    for name, count in columns.texts.items():
        yield f"{name} is a text in {count:,} runs, of which there are no means."
    for name, values in columns.measures.items():
        if len(columns) and not (values == values).any() and name not in columns.texts:  # noqa: PLR0124 - NaN
            yield f"{name} has no value in any run."


_FEWEST_BINS: Final = 8
_MOST_BINS: Final = 40


def endings_of(columns: Columns) -> tuple[Ending, ...]:
    """Return the endings of the runs."""
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
    """Return the effective number of the chosen runs."""
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
    """Return the histograms of the measures that have values, with the same edges for all treatments."""
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
    """Return the edges of bins: a bin for each of a few whole numbers, else by the rule of Freedman and Diaconis.

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


_MAX_POINTS: Final = 120


def running_of(columns: Columns) -> dict[str, dict[str, tuple[Point, ...]]]:
    """Return the running means of each measure that has values, by treatment; nothing for a single replication."""
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
    """Yield the running means of the chosen runs with Student's intervals, or Wilson's for shares."""
    np = arrays()
    values, replications, squares = measured[chosen], columns.replication[chosen], columns.squares[chosen]
    ends = np.flatnonzero(np.diff(replications, append=replications[-1] + 1))
    if len(ends) > _MAX_POINTS:
        ends = ends[np.unique(np.linspace(0, len(ends) - 1, _MAX_POINTS).round().astype(int))]
    counts = ends + 1
    # Squares of distances from the mean of all runs lose no digits.
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
