"""An experiment's report as one self-contained HTML page, in the style of a run's report."""

from __future__ import annotations

import math
import shlex
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import PurePath
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from markupsafe import Markup

from hmrsim.drawing.canvas import element, number, path, titled
from hmrsim.experiments.contrast import SUCCESS
from hmrsim.experiments.report.comparisons import TREATMENT
from hmrsim.report.charts import picture
from hmrsim.report.html import UNKNOWN, page_around, part, templates

if TYPE_CHECKING:
    from hmrsim.experiments.report.model import Comparison, Ending, Estimate, Point, Summary, Treatment

_COLORS: Final = {"timeout": "waiting", "failed": "fault"}
_BROKEN: Final = ("crashed", "hung", "deadlock", "out_of_memory", "died", "error")
_SUCCESSES: Final = ("succeeded", "charger")
_OTHERS: Final = ("busy", "lift", "ahead", "door", "idle")
_MAX_FILE: Final = 200_000
_LEAST, _MOST = 1e-4, 1e9


def figure(value: float | None, *, sign: bool = False, digits: int = 4) -> str:
    """Return a number with some significant digits, or all digits before the point; *sign* adds a plus sign."""
    if value is None:
        return UNKNOWN
    plus = "+" if sign and value > 0 else ""
    if value == 0 or not math.isfinite(value):
        return f"{value + 0.0:g}"
    if not _LEAST <= abs(value) < _MOST:
        return f"{plus}{value:.3e}"
    decimals = max(0, digits - 1 - math.floor(math.log10(abs(value))))
    text = f"{value:,.{decimals}f}"
    return plus + (text.rstrip("0").rstrip(".") if decimals else text)


def points(value: float | None) -> str:
    """Return a difference of two shares, in points of percent."""
    if value is None:
        return UNKNOWN
    text = f"{100 * value:+.1f}".removesuffix(".0")
    return "0 %" if text in {"+0", "-0"} else f"{text} %"


def levels(said: Mapping[str, Any]) -> str:
    """Return the levels of a scenario."""
    return ", ".join(f"{name}={level}" for name, level in said.items()) or UNKNOWN


def page_of(summary: Summary, folder: str) -> str:
    """Return the report of an experiment as a self-contained page; *folder* has the results, as on a command line."""
    environment = templates(__package__)
    environment.filters |= {
        "figure": figure,
        "points": points,
        "levels": levels,
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
        colors=_colors(summary.endings),
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


def _measure(summary: Summary, name: str) -> dict[str, Any]:
    """Return the charts of a measure: means and histograms by treatment, and running means."""
    means = {each.name: each.success if name == SUCCESS else each.measures[name].mean for each in summary.treatments}
    reach = _reach(name, means.values())
    label = f"Mean of {name} with its interval"
    histogram, curves = summary.distributions.get(name), summary.running.get(name, {})
    axis = axis_of(_settled(curves.values()))
    axis = shares_axis(axis) if name == SUCCESS else axis
    last = max((points[-1].replications for points in curves.values()), default=0)
    return {
        "name": name,
        "means": {
            treatment: _svg(interval_chart(mean, reach, f"{label}, {treatment}")) for treatment, mean in means.items()
        },
        "histograms": _histograms(name, histogram.edges, histogram.counts) if histogram else {},
        "ticks": ticks_of(Axis(histogram.edges[0], histogram.edges[-1])) if histogram else (),
        "curves": [
            {
                "treatment": treatment,
                "mean": points[-1].mean,
                "svg": _svg(running_chart(points, axis, last, f"{name} of {treatment} by replications")),
            }
            for treatment, points in curves.items()
        ],
        "low": axis.low,
        "high": axis.high,
        "replications": last,
    }


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
    """Return the differences of a comparison's measures, each on a separate axis."""
    found = {}
    for name, each in comparison.measures.items():
        bounds, margin = each.difference, each.margin
        if margin is not None and each.relative:
            # The verdict is about the true mean, and this is its estimate.
            margin *= abs(first.measures[name].mean.estimate or 0.0)
        axis = axis_around_zero([bounds.low, bounds.estimate, bounds.high, margin])
        label = f"Difference of {name} with its interval"
        found[name] = _svg(interval_chart(bounds, axis, label, line=0.0, margin=margin))
    return found


def _effects(summary: Summary, name: str) -> dict[str, list[Markup]]:
    """Return the charts of effects: the means at the levels of factors, and at pairs of levels, on one axis."""
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
    return {"levels": [*map(_svg, charts)], "interactions": [*map(_svg, both)]}


def _colors(endings: Sequence[Ending]) -> dict[str, str]:
    """Return the color of each ending, as the name of a style variable."""
    found: dict[str, str] = {}
    good, other = iter(_SUCCESSES), 0
    for ending in endings:
        if ending.success:
            found[ending.name] = next(good, _SUCCESSES[-1])
        elif ending.name in _COLORS or ending.name in _BROKEN:
            found[ending.name] = _COLORS.get(ending.name, "item")
        else:
            found[ending.name] = _OTHERS[other % len(_OTHERS)]
            other += 1
    return found


_WIDTH: Final = 1000.0
_BAR: Final = 24.0
_BARS: Final = 100.0
_PLOT: Final = (300.0, 100.0)
_SETTLED: Final = 0.2
"""The share of replications after which a running mean sets the scale, since single runs scatter widely."""
_MOST_TICKS: Final = 6


class Axis(NamedTuple):
    """The range of a chart."""

    low: float
    high: float

    def share(self, value: float) -> float:
        """Return the position of a value from 0 to 1; values outside the range are at its ends."""
        return min(1.0, max(0.0, (value - self.low) / (self.high - self.low)))


class Tick(NamedTuple):
    """A label of an axis, and its position in percent of the width."""

    at: float
    text: str


def axis_of(values: Iterable[float | None], *, room: float = 0.06) -> Axis:
    """Return an axis that has all values, with some room at its ends."""
    known = [value for value in values if value is not None]
    low, high = (min(known), max(known)) if known else (0.0, 1.0)
    pad = (high - low) * room or abs(high) * room or 1.0
    return Axis(low - pad, high + pad)


def shares_axis(axis: Axis) -> Axis:
    """Return an axis of shares, which are within 0 and 1."""
    return Axis(max(0.0, axis.low), min(1.0, axis.high))


def axis_around_zero(values: Iterable[float | None]) -> Axis:
    """Return an axis that has all values and 0 in its middle."""
    reach = max((abs(value) for value in values if value is not None), default=0.0) * 1.08 or 1.0
    return Axis(-reach, reach)


def ticks_of(axis: Axis) -> tuple[Tick, ...]:
    """Return round numbers on an axis."""
    span = axis.high - axis.low
    step = 10.0 ** math.floor(math.log10(span / _MOST_TICKS))
    step *= next(factor for factor in (1, 2, 5, 10, 20) if span / (step * factor) <= _MOST_TICKS)
    first = math.ceil(axis.low / step)
    values = (each * step for each in range(first, math.floor(axis.high / step) + 1))
    return tuple(Tick(100 * axis.share(value), figure(value)) for value in values)


def interval_chart(
    estimate: Estimate, axis: Axis, label: str, *, line: float | None = None, margin: float | None = None
) -> str:
    """Return an interval as SVG: a line with a point; nothing without an estimate.

    Args:
        estimate: The interval.
        axis: The range of the chart.
        label: The description for screen readers.
        line: The value of a vertical line, such as no difference.
        margin: The distance from the line within which differences do not matter.
    """
    if estimate.estimate is None:
        return ""

    def x(value: float) -> float:
        return axis.share(value) * _WIDTH

    parts = []
    if line is not None and margin is not None:
        left, right = x(line - margin), x(line + margin)
        parts.append(element("rect", class_="margin", x=left, y=0, width=right - left, height=_BAR))
    if line is not None:
        parts.append(element("path", class_="line", d=f"M{number(x(line))} 0V{number(_BAR)}"))
    middle = number(_BAR / 2)
    if estimate.low is not None and estimate.high is not None:
        parts.append(
            element("path", class_="reach", d=f"M{number(x(estimate.low))} {middle}H{number(x(estimate.high))}")
        )
    # A line of length 0 has round ends, which stay round even if the picture is stretched.
    parts.append(element("path", class_="point", d=f"M{number(x(estimate.estimate))} {middle}h0"))
    return picture(parts, label, _WIDTH, _BAR)


def histogram_chart(edges: Sequence[float], counts: Sequence[int], most: float, label: str) -> str:
    """Return a histogram as SVG, whose full height is the share *most* of the runs."""
    total = sum(counts)
    first, span = edges[0], edges[-1] - edges[0]
    parts = []
    for low, high, count in zip(edges, edges[1:], counts, strict=False):
        if count:
            height = count / total / most * (_BARS - 4)
            x = (low - first) / span * _WIDTH
            at = {"x": x, "y": _BARS - height, "width": (high - low) / span * _WIDTH, "height": height}
            title = titled(f"{figure(low)} to {figure(high)}: {count:,} runs, {count / total:.1%}")
            parts.append(element("rect", title, class_="bar", **at))
    return picture(parts, label, _WIDTH, _BARS)


def _settled(curves: Iterable[Sequence[Point]]) -> Iterator[float | None]:
    """Yield the values to which running means have settled, which decide the axis."""
    for points in curves:
        for point in points:
            if point.replications >= max(2, points[-1].replications * _SETTLED):
                yield from (point.mean.low, point.mean.estimate, point.mean.high)


def running_chart(points: Sequence[Point], axis: Axis, last: int, label: str) -> str:
    """Return running means with their bands as SVG, until the replication *last*."""
    width, height = _PLOT

    def at(point: Point, value: float) -> tuple[float, float]:
        # The picture clips values outside the axis.
        y = height * (1 - (value - axis.low) / (axis.high - axis.low))
        return (point.replications - 1) / max(1, last - 1) * width, min(10 * height, max(-10 * height, y))

    lows = [at(point, point.mean.low) for point in points if point.mean.low is not None]
    highs = [at(point, point.mean.high) for point in points if point.mean.high is not None]
    means = [at(point, point.mean.estimate) for point in points if point.mean.estimate is not None]
    end = number(means[-1][1])
    band = [element("path", class_="area", d=path([*lows, *reversed(highs)], closed=True))] if lows else []
    final = element("path", class_="low", d=f"M0 {end}H{number(width)}")
    return picture([*band, final, element("path", class_="line", d=path(means))], label, width, height)
