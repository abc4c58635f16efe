"""Writing the page of a run: its data as JSON, the map and the charts as SVG, in one HTML file."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

from markupsafe import Markup

from hmrsim import __version__
from hmrsim.drawing import Drawing, marks, type_looks
from hmrsim.drawing.canvas import element, group, path, text_of, titled
from hmrsim.drawing.labels import names
from hmrsim.history.robots import STATES
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.report.charts import THEME, timeline_of
from hmrsim.report.html import page_around, part, templates
from hmrsim.run_page.comparison import Cause, Difference, Heading, ShownRun, first_difference, is_left_out
from hmrsim.run_page.moments import moments_of
from hmrsim.run_page.run_log import MAX_LINES
from hmrsim.world.model import BUILT_IN_TYPES

if TYPE_CHECKING:
    from hmrsim.drawing.canvas import Frame
    from hmrsim.report.charts import Timeline
    from hmrsim.report.model import Report, Wait
    from hmrsim.run_page.run_log import RunLog, Tree

_QUIET: Final = 1.1
"""The end of the time axis, as a multiple of the time of the last change."""
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
    whole = _at(max(report.summary.sim_time for report in reports)) or 1.0
    changed = max([run.log.changed_until for run in runs] + [0.0 if difference is None else difference.at])
    length = _at(min(whole, changed * _QUIET + 1.0))
    timelines = [timeline_of(report, length) for report in reports]
    data = {
        "length": length,
        "whole": whole,
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
            changed=changed,
            faults=[_faults(report, length) for report in reports],
            maps=[Markup(_map(run.log)) for run in runs],  # noqa: S704 - escaped by the functions that made it
            rows=[*_rows(timelines)],
            ticks=timelines[0].ticks,
            most=MAX_LINES,
            cut=any(len(run.log.lines) == MAX_LINES for run in runs),
            sparse=failing.log.sparse,
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


def _at(seconds: float) -> float:
    """Return seconds in the precision of lines: events of an instant have the same."""
    return round(seconds, 6)


def _difference(difference: Difference | None) -> Any:
    if difference is None:
        return None
    return {"at": _at(difference.at), "lines": difference.lines, "seen": difference.seen}


def _faults(report: Report, length: float) -> list[tuple[float, float, str]]:
    """Return where the faults of a run are on the time axis, in percent of its length, and what they are."""
    found = []
    for fault in report.faults:
        ended = min(length, report.summary.sim_time if fault.ended is None else fault.ended)
        until = "the end of the run" if fault.ended is None else f"{fault.ended:.1f} s"
        text = f"{fault.fault} of {fault.subject}, {fault.began:.1f} s to {until}"
        found.append((100 * fault.began / length, 100 * (ended - fault.began) / length, text))
    return found


def _rows(timelines: Sequence[Timeline]) -> Iterator[tuple[str, str, list[str]]]:
    """Yield the name and type of each robot, and its row of the timeline in each run."""
    rows = [{row.robot: row for row in timeline.rows} for timeline in timelines]
    for name in dict.fromkeys(name for known in rows for name in known):
        own = [known.get(name) for known in rows]
        kind = next((row.type for row in own if row is not None), "")
        yield name, kind, [row.svg if row is not None else "" for row in own]


def _map(log: RunLog) -> str:
    """Return the map as SVG, with the robots and items, which the script moves."""
    world, frame, points = log.world, log.frame, log.world.points
    still = world.model_copy(update={"robots": {}, "items": {}, "bounds": frame.box})
    drawing = Drawing(still, width=log.width, names=False, legend=False, colors=THEME)
    size = drawing.mark
    closed_lanes, moved_doors = log.changes("lane"), log.changes("door")
    lanes = {f"{a}-{b}": (a, b) for lane in world.lanes for a, b in ((lane.from_, lane.to), (lane.to, lane.from_))}
    closed = (
        element("path", titled(f"{name} is closed"), d=path(frame.at(points[end]) for end in ends), data_lane=name)
        for name, ends in lanes.items()
        if name in closed_lanes
    )
    doors = (
        element("path", d=path(map(frame.at, door.at)), data_door=name)
        for name, door in world.doors.items()
        if name in moved_doors
    )
    boxes = (
        element(
            "g",
            marks.item((0.0, 0.0), size, THEME, titled(name)),
            element("text", text_of(name), x=size, y=size * 0.5) if log.sparse else "",
            data_item=name,
        )
        for name in log.changes("item")
    )
    radii = ((world.robot_type(robot).base.radius or 0.0) * frame.scale for robot in world.robots.values())
    over = [
        group("off-lanes", _off_lanes(log)),
        group("closed", closed),
        group("open-doors", doors),
        group("waits", [""]),
        names(drawing, max([1.2 * size, *radii]) if log.sparse else 0.0),
        group("robots", _robots(log, size)),
        group("items", boxes),
    ]
    return f"{drawing.svg().removesuffix('</svg>')}{''.join(over)}</svg>"


def _off_lanes(log: RunLog) -> Iterator[str]:
    """Yield the segments that robots drive off the lanes, such as in a world that is reduced to its waypoints."""
    for segment in log.report().paths:
        (x1, y1), (x2, y2) = log.frame.at(segment.begin), log.frame.at(segment.end)
        yield element("line", titled("driven off the lanes"), x1=x1, y1=y1, x2=x2, y2=y2)


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
        body = marks.robot((0.0, 0.0), radius, 0.0, look, THEME, flies=base.flies)
        ring = element("circle", class_="ring", r=radius * 1.3)
        label = element("text", text_of(name), y=-radius * 1.4, text_anchor="middle") if named else ""
        title = titled(f"{name}, {kind}")
        yield element("g", title, ring, element("g", body, class_="body"), label, data_robot=name)


def _run(run: ShownRun, report: Report) -> dict[str, Any]:
    """Return what the script needs of a run."""
    log = run.log
    own = {kind: _changes(log, kind) for kind in ("gone", "state", "goals")}
    compared = {each.line for each in log.happenings if each.told and not is_left_out(each.event)}
    return {
        "end": _at(report.summary.sim_time),
        "robots": [_robot(log, report, name, own) for name in log.poses],
        "items": _changes(log, "item", lambda value: _place_of(value, log.frame)),
        "doors": _changes(log, "door"),
        "lanes": _changes(log, "lane"),
        "lines": [[_at(line.at), line.subject, line.text, line.severity] for line in log.lines],
        "apart": [i for i in range(len(log.lines)) if i not in compared],
        "trees": [_tree(name, tree) for name, tree in log.trees.items()],
        "violations": [[_at(at), text] for at, text in run.violations],
    }


def _changes(log: RunLog, kind: str, shown: Callable[[Any], Any] = lambda value: value) -> dict[str, list[Any]]:
    """Return the changes of each member of a kind, by name."""
    return {
        name: [(_at(change.at), change.line, shown(change.value)) for change in changes]
        for name, changes in log.changes(kind).items()
    }


def _place_of(value: Any, frame: Frame) -> Any:
    """Return where an item is on the map: the name of its robot, or a point in pixels; None if it is gone."""
    if value is None or isinstance(value, str):
        return value
    x, y = frame.at((float(value[0]), float(value[1])))
    return round(x, 1), round(y, 1)


def _robot(log: RunLog, report: Report, name: str, changes: Mapping[str, Mapping[str, list[Any]]]) -> dict[str, Any]:
    frame = log.frame
    return {
        "name": name,
        "poses": log.poses[name].encoded(frame.at, turns=-1.0 if frame.up else 1.0),
        **{kind: known.get(name, []) for kind, known in changes.items()},
        "waits": [_wait(log, wait) for wait in report.waits if wait.robot == name],
        "battery": [[_at(at), round(share, 4)] for at, share in report.batteries.get(name, ())],
    }


def _wait(log: RunLog, wait: Wait) -> list[Any]:
    """Return begin, end, reason and robots of a wait; one in a queue is for the robots that were docked then."""
    why, robots = wait.why, wait.robots
    if wait.kind == "dock":
        why, robots = f"the queue of {wait.why}", log.queues.get((wait.robot, round(wait.began * NANOSECONDS)), ())
    return [_at(wait.began), _at(wait.ended), why, robots]


def _tree(name: str, tree: Tree) -> dict[str, Any]:
    texts: dict[str, int] = {}
    ticks = [
        [
            _at(tick.at),
            tick.line,
            tick.shape,
            tick.statuses,
            [each for i, text in tick.messages.items() for each in (i, texts.setdefault(text, len(texts)))],
        ]
        for tick in tree.ticks
    ]
    return {"robot": name, "shapes": tree.shapes, "ticks": ticks, "texts": [*texts]}
