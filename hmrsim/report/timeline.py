"""The timeline: for each robot a row, with its goals above and what it was doing below."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from typing import TYPE_CHECKING, Final, NamedTuple

from hmrsim.drawing.svg import element, number, titled
from hmrsim.report.charts import picture
from hmrsim.report.wording import seconds

if TYPE_CHECKING:
    from hmrsim.report.model import FaultSpan, Goal, Report, Span, Wait

WIDTH: Final = 10_000
"""The width of a row, in its own units; it is scaled to the available width."""

_ROWS: Final = 1_000
_MAX_BARS: Final = 20_000
_RESOLUTIONS: Final = (0.0, 2.5, 10.0, 40.0, 160.0)
"""The length, in units of a row, within which goals are merged if there are too many for a browser."""

_STEPS: Final = (0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 14400, 43200, 86400)
_TICKS: Final = 8


class Row(NamedTuple):
    """One robot's."""

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

    def width(self, began: float, ended: float) -> float:
        return max(1.0, (ended - began) / self.length * WIDTH)


class _Bar(NamedTuple):
    """Goals that are drawn as one bar."""

    began: float
    ended: float
    goals: tuple[Goal, ...]
    second: bool


def timeline_of(report: Report) -> Timeline:
    """Return the timeline of a report."""
    began = min((robot.began for robot in report.robots), default=0.0)
    scale = _Scale(began, report.summary.sim_time or 1.0)
    goals, spans = defaultdict[str, list["Goal"]](list), defaultdict[str, list["Span"]](list)
    waits, faults = defaultdict[str, list["Wait"]](list), defaultdict[str, list["FaultSpan"]](list)
    for goal in report.goals:
        goals[goal.robot].append(goal)
    for span in report.states:
        spans[span.robot].append(span)
    for wait in report.waits:
        waits[wait.robot].append(wait)
    for fault in report.faults:
        faults[fault.robot].append(fault)
    robots = report.robots[:_ROWS]
    end = scale.began + scale.length
    resolution = 0.0
    for resolution in _RESOLUTIONS:
        bars = {robot.name: _bars(goals[robot.name], end, resolution / WIDTH * scale.length) for robot in robots}
        if sum(map(len, bars.values())) <= _MAX_BARS:
            break
    rows, most_waits = [], _MAX_BARS // max(1, len(robots)) + 20
    for robot in robots:
        parts = [
            *(_goal_bar(bar, scale) for bar in bars[robot.name]),
            *_states(spans[robot.name], scale),
            *(_wait_bar(wait, scale) for wait in waits[robot.name][:most_waits]),
            *(_fault_bar(fault, scale, end) for fault in faults[robot.name]),
        ]
        svg = picture(parts, f"{robot.name}: {len(goals[robot.name])} goals", WIDTH, 24) if parts else ""
        rows.append(Row(robot.name, robot.type, svg))
    together = resolution / WIDTH * scale.length
    left_out = sum(max(0, len(waits[robot.name]) - most_waits) for robot in robots)
    return Timeline(tuple(rows), tuple(_ticks(scale)), len(report.robots) - len(robots), together, left_out)


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
    return element(
        "rect", title, class_=f"g {worst.status.lower()}", x=scale.x(bar.began), y=y, width=width, height=height
    )


_BY_GRAVITY: Final = ("ABORTED", "CANCELED", "CANCELING", "EXECUTING", "ACCEPTED", "SUCCEEDED")


def _about(goal: Goal) -> str:
    ended = "" if goal.ended is None else f" to {goal.ended:.1f}"
    lines = [f"{goal.action} {goal.target}".strip(), f"{goal.status}, {goal.accepted:.1f}{ended} s"]
    if goal.waited:
        lines.append(f"waited {seconds(goal.waited)}")
    if goal.error_msg:
        lines.append(goal.error_msg)
    return "\n".join(lines)


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
    return element(
        "rect", title, class_="f", x=scale.x(fault.began), y=0, width=scale.width(fault.began, ended), height=24
    )


def _ticks(scale: _Scale) -> Iterator[Tick]:
    step = next((step for step in _STEPS if scale.length / step <= _TICKS), _STEPS[-1])
    step *= max(1, -(-scale.length // (step * _TICKS * 4)))
    first = int(-(-scale.began // step))
    for i in range(first, int((scale.began + scale.length) // step) + 1):
        yield Tick(round((i * step - scale.began) / scale.length * 100, 3), f"{i * step:g} s")
