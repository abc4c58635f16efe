"""Charts of a report: goals and batteries over time, the timeline of robots, and the heat map."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Final, NamedTuple, TypeVar

from hmrsim.drawing import PALETTE, Drawing
from hmrsim.drawing.canvas import element, group, number, titled
from hmrsim.report.html import seconds, times

if TYPE_CHECKING:
    from hmrsim.drawing.canvas import Frame
    from hmrsim.report.model import Bucket, Error, FaultSpan, Goal, Report, Span, Wait
    from hmrsim.world.model import World

THEME: Final = {name: f"var(--{name.replace('_', '-')})" for name in PALETTE["light"]}
"""The colors of the theme, which the page chooses."""

E = TypeVar("E", "Goal", "Error", "Span", "Wait", "FaultSpan")

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


STEPS: Final = 6
"""Colors, from seldom to often."""

_MAX_WIDTH: Final = 9.0
_MAX_RADIUS: Final = 26.0
_MIN_RADIUS: Final = 3.0


def heat_map(report: Report, world: World) -> str:
    """Return the map as SVG, in the page's colors."""
    drawing = Drawing(world, width=1100.0, legend=False, colors=THEME)
    most = most_drives(report)
    looks, notes = {}, {}
    for lane in report.lanes:
        if lane.begin and lane.drives:
            step = step_of(lane.drives, most)
            looks[lane.begin, lane.end] = f"var(--heat-{step})", 2.0 + (_MAX_WIDTH - 2.0) * step / STEPS
            waited = f", {times(lane.waits, 'wait')}, {seconds(lane.waited)} in all" if lane.waits else ""
            notes[lane.begin, lane.end] = f"driven {times(lane.drives)}{waited}"
    svg = drawing.svg(looks, lane_notes=notes)
    over = group("paths", _paths(report, drawing.frame, most)) + group("waits", _waits(report, drawing.frame))
    return f"{svg.removesuffix('</svg>')}{over}</svg>"


def most_drives(report: Report) -> int:
    """Return the number of drives of the most used lane or segment, in one direction."""
    return max([1, *(lane.drives for lane in report.lanes if lane.begin), *(path.drives for path in report.paths)])


def step_of(drives: int, most: int) -> int:
    """Return the color of a number of drives, from 1."""
    return max(1, math.ceil(STEPS * drives / most))


def _paths(report: Report, frame: Frame, most: int) -> Iterator[str]:
    for path in report.paths:
        (x1, y1), (x2, y2) = frame.at(path.begin), frame.at(path.end)
        step = step_of(path.drives, most)
        look = {"stroke": f"var(--heat-{step})", "stroke_dasharray": "2 3", "stroke_linecap": "round"}
        title = titled(f"off the lanes: driven {times(path.drives)}")
        yield element("line", title, x1=x1, y1=y1, x2=x2, y2=y2, stroke_width=1.5 + step / 2, **look)


def _waits(report: Report, frame: Frame) -> Iterator[str]:
    spots: dict[tuple[float, float], list[float]] = defaultdict(list)
    for wait in report.waits:
        if wait.x is not None and wait.y is not None:
            spots[round(wait.x, 1), round(wait.y, 1)].append(wait.duration)
    longest = max(map(sum, spots.values()), default=0.0) or 1.0
    for at, waits in sorted(spots.items(), key=lambda spot: (-sum(spot[1]), spot[0])):
        x, y = frame.at(at)
        radius = max(_MIN_RADIUS, _MAX_RADIUS * math.sqrt(sum(waits) / longest))
        title = titled(f"{times(len(waits), 'wait')} at ({at[0]:g}, {at[1]:g}), {seconds(sum(waits))} in all")
        yield element("circle", title, class_="waited", cx=x, cy=y, r=radius)


WIDTH: Final = 10_000
"""The width of a row, in its own units; it is scaled to the available width."""

_ROWS: Final = 1_000
_MAX_BARS: Final = 20_000
_RESOLUTIONS: Final = (0.0, 2.5, 10.0, 40.0, 160.0)
"""The length, in units of a row, within which goals are merged if there are too many for a browser."""

_NARROWEST: Final = 20.0
"""The width of a goal's bar, in units of a row, below which it is a mark: its outline makes it wide enough."""

_STEPS: Final = (0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 14400, 43200, 86400)
_TICKS: Final = 8


class Row(NamedTuple):
    """The row of one robot."""

    robot: str
    type: str
    svg: str


class Tick(NamedTuple):
    """A label of the time axis, and its position in percent of the width."""

    at: float
    text: str


class Timeline(NamedTuple):
    """All rows; *left_out* robots have none; *together* is the length within which short goals are merged.

    *waits_left_out* are not drawn, as there are too many.
    """

    rows: tuple[Row, ...]
    ticks: tuple[Tick, ...]
    left_out: int
    together: float
    waits_left_out: int


class _Scale(NamedTuple):
    began: float
    length: float

    def x(self, at: float) -> float:
        return (at - self.began) / self.length * WIDTH

    def is_short(self, bar: _Bar) -> bool:
        """Return whether a bar is too narrow to be seen, so that it is a mark over its neighbors."""
        return self.width(bar.began, bar.ended) < _NARROWEST

    def width(self, began: float, ended: float) -> float:
        return max(1.0, (ended - began) / self.length * WIDTH)


class _Bar(NamedTuple):
    """Goals that are drawn as one bar."""

    began: float
    ended: float
    goals: tuple[Goal, ...]
    second: bool


def timeline_of(report: Report, length: float | None = None) -> Timeline:
    """Return the timeline of a report; *length* is that of the axis in seconds, instead of that of the run."""
    began = min((robot.began for robot in report.robots), default=0.0)
    scale = _Scale(began, length or report.summary.sim_time or 1.0)
    goals, spans = _by_robot(report.goals), _by_robot(report.states)
    waits, faults = _by_robot(report.waits), _by_robot(report.faults)
    rejected = _by_robot(error for error in report.errors if error.status == "REJECTED")
    robots = report.robots[:_ROWS]
    end = scale.began + (report.summary.sim_time or scale.length)
    resolution = 0.0
    for resolution in _RESOLUTIONS:
        bars = {robot.name: _bars(goals[robot.name], end, resolution / WIDTH * scale.length) for robot in robots}
        if sum(map(len, bars.values())) <= _MAX_BARS:
            break
    rows, most_waits = [], _MAX_BARS // max(1, len(robots)) + 20
    for robot in robots:
        parts = [
            *(_goal_bar(bar, scale) for bar in sorted(bars[robot.name], key=scale.is_short)),
            *_rejections(rejected[robot.name], scale),
            *_states(spans[robot.name], scale),
            *(_wait_bar(wait, scale) for wait in waits[robot.name][:most_waits]),
            *(_fault_bar(fault, scale, end) for fault in faults[robot.name]),
        ]
        svg = picture(parts, f"{robot.name}: {len(goals[robot.name])} goals", WIDTH, 24) if parts else ""
        rows.append(Row(robot.name, robot.type, svg))
    together = resolution / WIDTH * scale.length
    left_out = sum(max(0, len(waits[robot.name]) - most_waits) for robot in robots)
    return Timeline(tuple(rows), tuple(_ticks(scale)), len(report.robots) - len(robots), together, left_out)


def _by_robot(entries: Iterable[E]) -> dict[str, list[E]]:
    groups = defaultdict[str, list[E]](list)
    for entry in entries:
        groups[entry.robot].append(entry)
    return groups


def _bars(goals: list[Goal], end: float, gap: float) -> list[_Bar]:
    """Return the bars of a robot's goals; short goals that are near each other are merged."""
    bars: list[_Bar] = []
    busy_until = float("-inf")
    for goal in goals:
        ended = end if goal.ended is None else goal.ended
        last = bars[-1] if bars else None
        if last and gap and ended - last.began <= gap:
            bars[-1] = _Bar(last.began, max(last.ended, ended), (*last.goals, goal), second=False)
        else:
            bars.append(_Bar(goal.accepted, ended, (goal,), second=goal.accepted < busy_until))
        busy_until = max(busy_until, ended)
    return bars


def _goal_bar(bar: _Bar, scale: _Scale) -> str:
    worst = min(bar.goals, key=lambda goal: _BY_GRAVITY.index(goal.status))
    title = titled(
        _about(bar.goals[0]) if len(bar.goals) == 1 else f"{len(bar.goals)} goals, {bar.began:.1f} to {bar.ended:.1f} s"
    )
    y, height = (8, 5) if bar.second else (2, 11)
    width = scale.width(bar.began, bar.ended)
    x, kind = min(scale.x(bar.began), WIDTH - width), f"g {worst.status.lower()}"
    if scale.is_short(bar):
        x, kind = min(x, WIDTH - _NARROWEST), f"{kind} mark"
    return element("rect", title, class_=kind, x=x, y=y, width=width, height=height)


_BY_GRAVITY: Final = ("ABORTED", "CANCELED", "CANCELING", "EXECUTING", "ACCEPTED", "SUCCEEDED")


def _about(goal: Goal) -> str:
    ended = "" if goal.ended is None else f" to {goal.ended:.1f}"
    lines = [f"{goal.action} {goal.target}".strip(), f"{goal.status}, {goal.accepted:.1f}{ended} s"]
    if goal.waited:
        lines.append(f"waited {seconds(goal.waited)}")
    if goal.error_msg:
        lines.append(goal.error_msg)
    return "\n".join(lines)


def _rejections(rejected: list[Error], scale: _Scale) -> Iterator[str]:
    """Yield one path for all rejected goals of a robot."""
    # Those that would be drawn over each other are one mark.
    marks = dict.fromkeys(min(scale.x(each.at) // _NARROWEST * _NARROWEST, WIDTH - _NARROWEST) for each in rejected)
    if marks:
        title = titled(f"goals rejected {times(len(rejected))}, from {rejected[0].at:.1f} to {rejected[-1].at:.1f} s")
        yield element("path", title, class_="g rejected mark", d="".join(f"M{number(x)} 2v5" for x in marks))


def _states(spans: list[Span], scale: _Scale) -> Iterator[str]:
    """Return a path for each state without tooltips."""
    parts: dict[str, list[str]] = defaultdict(list)
    for span in spans:
        if span.state != "idle":
            width = number(scale.width(span.began, span.ended))
            parts[span.state].append(f"M{number(scale.x(span.began))} 18.5h{width}")
    for state, steps in sorted(parts.items()):
        yield element("path", titled(state), class_=f"s {state}", d="".join(steps))


def _wait_bar(wait: Wait, scale: _Scale) -> str:
    what = (
        f"for {', '.join(wait.robots)}"
        if wait.robots
        else f"in the queue of {wait.why}"
        if wait.kind == "dock"
        else f": {wait.why}"
    )
    title = titled(f"waited {seconds(wait.duration)} {what}\n{wait.began:.1f} to {wait.ended:.1f} s")
    width = scale.width(wait.began, wait.ended)
    return element("rect", title, class_=f"w {wait.kind}", x=scale.x(wait.began), y=15, width=width, height=7)


def _fault_bar(fault: FaultSpan, scale: _Scale, end: float) -> str:
    ended = end if fault.ended is None else fault.ended
    until = "the end" if fault.ended is None else f"{fault.ended:.1f} s"
    title = titled(f"{fault.fault} {fault.name}, {fault.began:.1f} s to {until}")
    width = max(_NARROWEST, scale.width(fault.began, ended))
    return element("rect", title, class_="f", x=scale.x(fault.began), y=0, width=width, height=24)


def _ticks(scale: _Scale) -> Iterator[Tick]:
    step = next((step for step in _STEPS if scale.length / step <= _TICKS), _STEPS[-1])
    step *= max(1, -(-scale.length // (step * _TICKS * 4)))
    first = int(-(-scale.began // step))
    for i in range(first, int((scale.began + scale.length) // step) + 1):
        yield Tick(round((i * step - scale.began) / scale.length * 100, 3), f"{i * step:g} s")
