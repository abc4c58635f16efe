"""Small charts of a report: goals that ended over time, and what was left in batteries."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Final, NamedTuple

from hmrsim.drawing.svg import element, number, titled

if TYPE_CHECKING:
    from hmrsim.report.model import Bucket, Report, Span

_WIDTH, _HEIGHT = 1000.0, 160.0
MAX_BATTERIES: Final = 60
"""Maximum number of curves."""

_CURVE: Final = (300.0, 60.0)


class Curve(NamedTuple):
    """A robot's battery over time."""

    robot: str
    last: float
    lowest: float
    svg: str


def picture(parts: Sequence[str], label: str, width: float, height: float) -> str:
    """Return SVG that is stretched to the room that it has; *label* says what it shows."""
    view = f"0 0 {number(width)} {number(height)}"
    return element("svg", *parts, viewBox=view, preserveAspectRatio="none", role="img", aria_label=label)


def throughput_chart(buckets: Sequence[Bucket]) -> tuple[str, int]:
    """Return the chart of the goals that ended as SVG, and the maximum of its intervals."""
    most = max((each.succeeded + each.canceled + each.aborted for each in buckets), default=0)
    if not most:
        return "", 0
    width = _WIDTH / len(buckets)
    parts = []
    for i, bucket in enumerate(buckets):
        y, span = _HEIGHT, f"{bucket.began:g} to {bucket.ended:g} s"
        for status in ("succeeded", "canceled", "aborted"):
            if count := getattr(bucket, status):
                height = count / most * (_HEIGHT - 10)
                y -= height
                at = {"x": i * width + width * 0.08, "y": y, "width": width * 0.84, "height": height}
                parts.append(element("rect", titled(f"{span}: {count} {status}"), class_=f"g {status}", **at))
    return picture(parts, "Goals that ended, over time", _WIDTH, _HEIGHT), most


def battery_curves(report: Report) -> tuple[Curve, ...]:
    """Return the curves of the batteries, the lowest first."""
    lowest = sorted(report.batteries.items(), key=lambda each: (min(share for _, share in each[1]), each[0]))
    charging: dict[str, list[Span]] = {}
    for span in report.states:
        if span.state == "charging":
            charging.setdefault(span.robot, []).append(span)
    began = min((robot.began for robot in report.robots), default=0.0)
    length = report.summary.sim_time or 1.0
    return tuple(_curve(name, points, charging.get(name, []), began, length) for name, points in lowest[:MAX_BATTERIES])


def _curve(
    name: str, points: Sequence[tuple[float, float]], charging: Sequence[Span], began: float, length: float
) -> Curve:
    width, height = _CURVE

    def x(at: float) -> float:
        return (at - began) / length * width

    def y(share: float) -> float:
        return height - share * height

    line = "L".join(f"{number(x(at))} {number(y(share))}" for at, share in points)
    area = f"M{number(x(points[0][0]))} {number(height)}L{line}L{number(x(points[-1][0]))} {number(height)}Z"
    parts = [
        *_charged(charging, x),
        element("path", class_="area", d=area),
        element("path", class_="low", d=f"M0 {number(y(0.2))}H{number(width)}"),
        element("path", class_="line", d=f"M{line}"),
    ]
    svg = picture(parts, f"Battery of {name} over time", width, height)
    return Curve(name, points[-1][1], min(share for _, share in points), svg)


def _charged(spans: Sequence[Span], x: Callable[[float], float]) -> Iterator[str]:
    for span in spans:
        began = x(span.began)
        title = titled(f"charging, {span.began:.1f} to {span.ended:.1f} s")
        yield element("rect", title, class_="charged", x=began, y=0, width=x(span.ended) - began, height=_CURVE[1])
