"""An experiment's report as one self-contained HTML page, in the style of a run's report."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Sequence
from pathlib import PurePath
from typing import TYPE_CHECKING, Final, NamedTuple

from markupsafe import Markup

from hmrsim.experiments.comparing import SUCCESS
from hmrsim.experiments.report import wording
from hmrsim.experiments.report.charts import (
    Axis,
    Tick,
    axis_around_zero,
    axis_of,
    histogram_chart,
    interval_chart,
    running_axis,
    running_chart,
    shares_axis,
    ticks_of,
)
from hmrsim.experiments.report.effects import TREATMENT
from hmrsim.report.html import page_around, part, templates

if TYPE_CHECKING:
    from hmrsim.experiments.report.model import Comparison, Ending, Estimate, Summary, Treatment

_COLOURS: Final = {"timeout": "waiting", "failed": "fault"}
_BROKEN: Final = ("crashed", "hung", "deadlock", "out_of_memory", "died", "error")
_SUCCESSES: Final = ("succeeded", "charger")
_OTHERS: Final = ("busy", "lift", "ahead", "door", "idle")
_MAX_FILE: Final = 200_000


class _Curve(NamedTuple):
    """The running mean of a treatment."""

    treatment: str
    mean: Estimate
    svg: Markup


class _Measure(NamedTuple):
    """What is drawn of a measure: means and histograms by treatment, and running means."""

    name: str
    means: dict[str, Markup]
    histograms: dict[str, Markup]
    ticks: Sequence[Tick]
    curves: Sequence[_Curve]
    low: float
    high: float
    replications: int


class _Effects(NamedTuple):
    """What is drawn of effects: the means at levels of factors, on one axis, and at two levels together."""

    levels: Sequence[Markup]
    interactions: Sequence[Markup]


def page_of(summary: Summary, folder: str) -> str:
    """Return the page.

    Args:
        summary: What the results say.
        folder: The folder of the results, as a command line has it.
    """
    environment = templates(__package__)
    environment.filters |= {
        "figure": wording.figure,
        "points": wording.points,
        "levels": wording.levels,
        "count": "{:,}".format,
    }
    said = summary.experiment
    body: str = environment.get_template("experiment.html").render(
        summary=summary,
        said=said,
        folder=folder,
        command=_command(summary, folder),
        text=said.text[:_MAX_FILE],
        cut=len(said.text) > _MAX_FILE,
        measures=[_measure(summary, name) for name in summary.measures],
        differences=[_differences(comparison, summary.treatments[0]) for comparison in summary.comparisons],
        effects={name: _effects(summary, name) for name in summary.effects},
        headings={
            "treatments": ["treatment", "#runs", *(f"#{name}" for name in summary.measures)],
            "endings": ["treatment", "share of runs", *(f"#{ending.name}" for ending in summary.endings)],
        },
        colours=_colours(summary.endings),
        undecided=sum(each.verdict == "undecided" for one in summary.comparisons for each in one.measures.values()),
        verdicts=sum(len(one.measures) for one in summary.comparisons),
    )
    whole = Markup(body)  # noqa: S704 - escaped by the template
    return page_around(said.name, whole, style=part("experiment.css", __package__))


def _command(summary: Summary, folder: str) -> str:
    said = summary.experiment
    variants = [word for name in said.variant for word in ("--variant", name)]
    return f"{shlex.join(['hmrsim', 'experiment', 'run', PurePath(said.path).name, *variants])} -o {folder}"


def _svg(text: str) -> Markup:
    return Markup(text)  # noqa: S704 - escaped by the functions that made it


def _measure(summary: Summary, name: str) -> _Measure:
    means = {each.name: each.success if name == SUCCESS else each.measures[name].mean for each in summary.treatments}
    reach = _reach(name, means.values())
    label = f"Mean of {name} with its interval"
    histogram, curves = summary.distributions.get(name), summary.running.get(name, {})
    axis = running_axis(curves.values())
    axis = shares_axis(axis) if name == SUCCESS else axis
    last = max((points[-1].replications for points in curves.values()), default=0)
    return _Measure(
        name,
        {treatment: _svg(interval_chart(mean, reach, f"{label}, {treatment}")) for treatment, mean in means.items()},
        _histograms(name, histogram.edges, histogram.counts) if histogram else {},
        ticks_of(Axis(histogram.edges[0], histogram.edges[-1])) if histogram else (),
        [
            _Curve(
                treatment,
                points[-1].mean,
                _svg(running_chart(points, axis, last, f"{name} of {treatment} by replications")),
            )
            for treatment, points in curves.items()
        ],
        axis.low,
        axis.high,
        last,
    )


def _reach(name: str, means: Iterable[Estimate]) -> Axis:
    """Return the axis of some intervals."""
    axis = axis_of(bound for mean in means for bound in (mean.low, mean.estimate, mean.high))
    return shares_axis(axis) if name == SUCCESS else axis


def _histograms(name: str, edges: Sequence[float], counts: dict[str, tuple[int, ...]]) -> dict[str, Markup]:
    most = max(count / sum(each) for each in counts.values() for count in each if count)
    return {
        treatment: _svg(histogram_chart(edges, each, most, f"Distribution of {name}, {treatment}"))
        for treatment, each in counts.items()
    }


def _differences(comparison: Comparison, first: Treatment) -> dict[str, Markup]:
    """Return the differences of a comparison's measures, each on an axis of its own."""
    found = {}
    for name, each in comparison.measures.items():
        bounds, margin = each.difference, each.margin
        if margin is not None and each.relative:
            # What the verdict is about is the true mean, of which this is the estimate.
            margin *= abs(first.measures[name].mean.estimate or 0.0)
        axis = axis_around_zero([bounds.low, bounds.estimate, bounds.high, margin])
        label = f"Difference of {name} with its interval"
        found[name] = _svg(interval_chart(bounds, axis, label, line=0.0, margin=margin))
    return found


def _effects(summary: Summary, name: str) -> _Effects:
    found = summary.effects[name]
    levels = [level for level in found.levels if level.factor != TREATMENT]
    axis = _reach(name, [level.mean for level in levels])
    charts = [
        interval_chart(level.mean, axis, f"Mean of {name} at {level.factor} {level.level}", line=found.mean)
        for level in levels
    ]
    axis = _reach(name, [each.mean for each in found.interactions])
    both = [
        interval_chart(each.mean, axis, f"Mean of {name} at {' and '.join(each.levels)}", line=each.expected)
        for each in found.interactions
    ]
    return _Effects([*map(_svg, charts)], [*map(_svg, both)])


def _colours(endings: Sequence[Ending]) -> dict[str, str]:
    """Return the colour of each ending, as the name of a variable of the style."""
    found: dict[str, str] = {}
    good, other = iter(_SUCCESSES), 0
    for ending in endings:
        if ending.success:
            found[ending.name] = next(good, _SUCCESSES[-1])
        elif ending.name in _COLOURS or ending.name in _BROKEN:
            found[ending.name] = _COLOURS.get(ending.name, "item")
        else:
            found[ending.name] = _OTHERS[other % len(_OTHERS)]
            other += 1
    return found
