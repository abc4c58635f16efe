"""Writing the page of a run: its data as JSON, the map and the charts as SVG, in one HTML file."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, Final

from markupsafe import Markup

from hmrsim import __version__
from hmrsim.drawing import PALETTE, Drawing, marks, type_looks
from hmrsim.drawing.canvas import element, group, path, text_of, titled
from hmrsim.history.robots import STATES
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.report.charts import timeline_of
from hmrsim.report.html import page_around, part, templates
from hmrsim.run_page.comparison import Cause, Difference, Heading, ShownRun, first_difference, moments_of
from hmrsim.run_page.run_log import MAX_LINES, WIDTH, place_of
from hmrsim.world.model import BUILT_IN_TYPES

if TYPE_CHECKING:
    from hmrsim.report.model import Goal, Report, Wait
    from hmrsim.run_page.run_log import RunLog, Tree

_COLORS: Final = {name: f"var(--{name.replace('_', '-')})" for name in PALETTE["light"]}
"""The colors of the theme, which the page chooses."""
_QUIET: Final = 1.1
"""The part of a run that is shown, if nothing happens any more, as a multiple of that before it."""
_MAX_NAMES: Final = 40
"""The maximum number of robots whose names are on the map."""


def page_of(heading: Heading, causes: Sequence[Cause], runs: tuple[ShownRun] | tuple[ShownRun, ShownRun]) -> str:
    """Return the page of a run; the same runs give the same page, byte for byte.

    Args:
        heading: The texts at its top.
        causes: The faults and disturbances of the first run.
        runs: The run, and the one beside it if there is one.
    """
    failing, other = runs[0], runs[1] if len(runs) > 1 else None
    reports = [run.log.report() for run in runs]
    difference = first_difference(failing.log, other.log) if other is not None else None
    moments = moments_of(causes, failing, other, difference)
    whole = max(report.summary.sim_time for report in reports) or 1.0
    length = min(whole, max(run.log.quiet_from for run in runs) * _QUIET + 1.0)
    data = {
        "length": round(length, 3),
        "at": round(difference.at if difference else moments[0].at, 3),
        "difference": _difference(difference),
        "runs": [_run(run, report) for run, report in zip(runs, reports, strict=True)],
    }
    body: str = (
        templates(__package__)
        .get_template("run.html")
        .render(
            heading=heading,
            causes=causes,
            moments=moments,
            runs=runs,
            length=length,
            whole=whole,
            faults=[_faults(report, length) for report in reports],
            maps=[Markup(_map(run.log)) for run in runs],  # noqa: S704 - escaped by the functions that made it
            rows=[*_rows(reports, length)],
            ticks=timeline_of(reports[0], length=length).ticks,
            most=MAX_LINES,
            cut=any(len(run.log.lines) == MAX_LINES for run in runs),
            trees=any(run.log.trees for run in runs),
            states=STATES,
            version=__version__,
            data=Markup(_embedded(data)),  # noqa: S704 - escaped
        )
    )
    shown = Markup(body)  # noqa: S704 - escaped by the template
    return page_around(heading.title, shown, script=part("page.js", __package__), style=part("page.css", __package__))


def _embedded(data: Any) -> str:
    """Return JSON that may stand in a script element, whatever texts are in it."""
    text = json.dumps(data, separators=(",", ":"), ensure_ascii=False)
    return text.replace("&", "\\u0026").replace("<", "\\u003c").replace(">", "\\u003e")


def _difference(difference: Difference | None) -> Any:
    return (
        None
        if difference is None
        else {
            "at": round(difference.at, 3),
            "lines": difference.lines,
            "seen": difference.seen,
        }
    )


def _faults(report: Report, length: float) -> list[tuple[float, float, str]]:
    """Return where the faults of a run are on the time axis, in percent of its length, and what they are."""
    found = []
    for fault in report.faults:
        ended = min(length, report.summary.sim_time if fault.ended is None else fault.ended)
        text = f"{fault.fault} of {fault.subject}, {fault.began:.1f} to {ended:.1f} s"
        found.append((100 * fault.began / length, 100 * (ended - fault.began) / length, text))
    return found


def _rows(reports: Sequence[Report], length: float) -> Iterator[tuple[str, str, list[str]]]:
    """Yield the name and type of each robot, and its row of the timeline in each run."""
    timelines = [timeline_of(report, length=length) for report in reports]
    rows = [{row.robot: row for row in timeline.rows} for timeline in timelines]
    for name in dict.fromkeys(name for known in rows for name in known):
        own = [known.get(name) for known in rows]
        kind = next((row.type for row in own if row is not None), "")
        yield name, kind, [row.svg if row is not None else "" for row in own]


def _map(log: RunLog) -> str:
    """Return the map as SVG, with the robots and items, which the script moves."""
    world, frame, points = log.world, log.frame, log.world.points
    still = world.model_copy(update={"robots": {}, "items": {}, "bounds": frame.box})
    drawing = Drawing(still, width=WIDTH, legend=False, colors=_COLORS)
    size = drawing.mark
    changed = dict(log.changes("lane"))
    lanes = {f"{a}-{b}": (a, b) for lane in world.lanes for a, b in ((lane.from_, lane.to), (lane.to, lane.from_))}
    closed = (
        element("path", titled(f"{name} is closed"), d=path(frame.at(points[end]) for end in ends), data_lane=name)
        for name, ends in lanes.items()
        if name in changed
    )
    doors = (
        element("path", d=path(map(frame.at, door.at)), data_door=name)
        for name, door in world.doors.items()
        if name in dict(log.changes("door"))
    )
    items = (
        element("g", marks.item((0.0, 0.0), size, _COLORS, titled(name)), data_item=name)
        for name, _ in log.changes("item")
    )
    over = [
        group("closed", closed),
        group("open-doors", doors),
        group("waits", [""]),
        group("items", items),
        group("robots", _robots(log, size)),
    ]
    return f"{drawing.svg().removesuffix('</svg>')}{''.join(over)}</svg>"


def _robots(log: RunLog, size: float) -> Iterator[str]:
    world, looks = log.world, type_looks(log.world)
    types = {robot.name: robot.type for robot in log.report().robots}
    known = {**BUILT_IN_TYPES, **world.robot_types}
    named = len(log.poses) <= _MAX_NAMES
    for name in log.poses:
        spec, kind = world.robots.get(name), types.get(name, "")
        base = (world.robot_type(spec) if spec else known[kind]).base
        radius = max(1.2 * size, (base.radius or 0.0) * log.frame.scale)
        look = looks.get(kind) or next(iter(looks.values()))
        body = marks.robot((0.0, 0.0), radius, 0.0, look, _COLORS, flies=base.flies)
        ring = element("circle", class_="ring", r=radius * 1.3)
        label = element("text", text_of(name), y=-radius * 1.4, text_anchor="middle") if named else ""
        title = titled(f"{name}, {kind}")
        yield element("g", title, ring, element("g", body, class_="body"), label, data_robot=name)


def _run(run: ShownRun, report: Report) -> dict[str, Any]:
    """Return what the script needs of a run."""
    log = run.log
    return {
        "end": round(report.summary.sim_time, 3),
        "robots": [_robot(log, report, name) for name in log.poses],
        "items": [
            [name, [[at, place_of(value, log.frame)] for at, value in values]] for name, values in log.changes("item")
        ],
        "doors": [[name, values] for name, values in log.changes("door")],
        "lanes": [[name, values] for name, values in log.changes("lane")],
        "lines": [[round(line.at, 3), line.subject, line.text, line.severity] for line in log.lines],
        "trees": [_tree(name, tree) for name, tree in log.trees.items()],
        "violations": [[round(at, 3), text] for at, text in run.violations],
    }


def _robot(log: RunLog, report: Report, name: str) -> dict[str, Any]:
    frame = log.frame
    goals = [_goal(goal) for goal in report.goals if goal.robot == name]
    return {
        "name": name,
        "poses": log.poses[name].encoded(frame.at, turns=-1.0 if frame.up else 1.0),
        "gone": dict(log.changes("gone")).get(name, []),
        "states": [
            [round(span.began, 3), round(span.ended, 3), STATES.index(span.state)]
            for span in report.states
            if span.robot == name and span.state != "idle"
        ],
        "goals": goals,
        "waits": [_wait(log, wait) for wait in report.waits if wait.robot == name],
        "battery": [[round(at, 3), round(share, 4)] for at, share in report.batteries.get(name, ())],
    }


def _goal(goal: Goal) -> list[Any]:
    ended = None if goal.ended is None else round(goal.ended, 3)
    return [round(goal.accepted, 3), ended, f"{goal.action} {goal.target}".strip(), goal.status.lower()]


def _wait(log: RunLog, wait: Wait) -> list[Any]:
    """Return begin, end, reason and robots of a wait; one in a queue is for the robots that were docked then."""
    why, robots = wait.why, wait.robots
    if wait.kind == "dock":
        why, robots = f"the queue of {wait.why}", log.queues.get((wait.robot, round(wait.began * NANOSECONDS)), ())
    return [round(wait.began, 3), round(wait.ended, 3), why, robots]


def _tree(name: str, tree: Tree) -> dict[str, Any]:
    texts: dict[str, int] = {}
    ticks = [
        [
            round(tick.at, 3),
            tick.line,
            tick.shape,
            tick.statuses,
            [each for i, text in tick.messages.items() for each in (i, texts.setdefault(text, len(texts)))],
        ]
        for tick in tree.ticks
    ]
    return {"robot": name, "shapes": tree.shapes, "ticks": ticks, "texts": [*texts]}
