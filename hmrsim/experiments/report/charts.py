"""Small charts of an experiment's report: intervals, histograms, and means that become known."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Final, NamedTuple

from hmrsim.drawing.svg import element, number, path, titled
from hmrsim.experiments.report.wording import figure
from hmrsim.report.charts import picture

if TYPE_CHECKING:
    from hmrsim.experiments.report.model import Estimate, Point

_WIDTH: Final = 1000.0
_BAR: Final = 24.0
_BARS: Final = 100.0
_PLOT: Final = (300.0, 100.0)
_SETTLED: Final = 0.2
"""The share of replications after which a running mean sets the scale: single runs may be anywhere."""
_MOST_TICKS: Final = 6


class Axis(NamedTuple):
    """What a chart reaches from and to."""

    low: float
    high: float

    def share(self, value: float) -> float:
        """Return where a value is, from 0 to 1; it is at an end if it is beyond."""
        return min(1.0, max(0.0, (value - self.low) / (self.high - self.low)))


class Tick(NamedTuple):
    """A label of an axis, and its position in percent of the width."""

    at: float
    text: str


def axis_of(values: Iterable[float | None], *, room: float = 0.06) -> Axis:
    """Return an axis on which all values are, with some room at its ends."""
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
        axis: What the chart reaches from and to.
        label: What it shows.
        line: Where an upright line is, such as at no difference.
        margin: How far to both sides of the line differences do not matter.
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
    # A line without length has round ends, which stay round however the picture is stretched.
    parts.append(element("path", class_="point", d=f"M{number(x(estimate.estimate))} {middle}h0"))
    return picture(parts, label, _WIDTH, _BAR)


def histogram_chart(edges: Sequence[float], counts: Sequence[int], most: float, label: str) -> str:
    """Return a histogram as SVG; *most* is the share of runs that its full height stands for."""
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


def running_axis(curves: Iterable[Sequence[Point]]) -> Axis:
    """Return the axis of running means: that of what they have settled to."""
    return axis_of(_settled(curves))


def _settled(curves: Iterable[Sequence[Point]]) -> Iterator[float | None]:
    for points in curves:
        for point in points:
            if point.replications >= max(2, points[-1].replications * _SETTLED):
                yield from (point.mean.low, point.mean.estimate, point.mean.high)


def running_chart(points: Sequence[Point], axis: Axis, last: int, label: str) -> str:
    """Return running means with their bands as SVG, until the replication *last*."""
    width, height = _PLOT

    def at(point: Point, value: float) -> tuple[float, float]:
        # What is beyond the axis is cut off by the picture.
        y = height * (1 - (value - axis.low) / (axis.high - axis.low))
        return (point.replications - 1) / max(1, last - 1) * width, min(10 * height, max(-10 * height, y))

    lows = [at(point, point.mean.low) for point in points if point.mean.low is not None]
    highs = [at(point, point.mean.high) for point in points if point.mean.high is not None]
    means = [at(point, point.mean.estimate) for point in points if point.mean.estimate is not None]
    end = number(means[-1][1])
    band = [element("path", class_="area", d=path([*lows, *reversed(highs)], closed=True))] if lows else []
    final = element("path", class_="low", d=f"M0 {end}H{number(width)}")
    return picture([*band, final, element("path", class_="line", d=path(means))], label, width, height)
