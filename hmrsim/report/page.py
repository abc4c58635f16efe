"""A report as a self-contained HTML page, which loads no external script, style, font or picture."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

from markupsafe import Markup

from hmrsim.errors import WorldError
from hmrsim.history.robots import STATES
from hmrsim.report.charts import (
    MAX_BATTERIES,
    STEPS,
    battery_curves,
    heat_map,
    most_drives,
    throughput_chart,
    timeline_of,
)
from hmrsim.report.delays import PART_OF
from hmrsim.report.html import page_around, part, templates
from hmrsim.trace.sections import restart_text
from hmrsim.world_checks.loading import world_of

if TYPE_CHECKING:
    from hmrsim.report.model import Report, Section

_MAX_ROWS: Final = 500
"""Maximum rows of a table; the JSON and the CSV files have all."""

_PART_COLORS: Final = {**{name: state for state, name in PART_OF.items()}, "queue": "offline"}
"""The state in whose color each part of a lead time is shown."""


def page_of(report: Report, definition: Mapping[str, Any]) -> str:
    """Return the page of a report; *definition* is the world of the run, as in a native file."""
    body = _body(report, definition, f"Report of a {report.source.kind}")
    return page_around(report.world.name, body, script=part("page.js"))


def page_of_sections(sections: Sequence[Section], definitions: Sequence[Mapping[str, Any]]) -> str:
    """Return the page of a trace: the report of its only section, or a list of its sections and the report of each.

    *definitions* are the worlds of the sections, as in native files.
    """
    if len(sections) == 1:
        return page_of(sections[0].report, definitions[0])
    bodies = []
    for section, definition in zip(sections, definitions, strict=True):
        why = f": {restart_text(section.cause)}" if section.cause else ""
        kind, prefix = f"Section {section.section}{why}", f"section-{section.section}-"
        bodies.append(_body(section.report, definition, kind, prefix=prefix, main="div"))
    body = templates().get_template("sections.html").render(sections=sections, bodies=bodies)
    whole = Markup(body)  # noqa: S704 - escaped by the template
    return page_around(sections[0].report.world.name, whole, script=part("page.js"))


def _body(report: Report, definition: Mapping[str, Any], kind: str, *, prefix: str = "", main: str = "main") -> Markup:
    """Return the body of a page; *prefix* is put before HTML ids, and *main* is the element of its main part."""
    chart, most = throughput_chart(report.throughput)
    body: str = (
        templates()
        .get_template("report.html")
        .render(
            kind=kind,
            prefix=prefix,
            main=main,
            report=report,
            unit=report.world.units,
            # The functions that draw SVG escape their texts.
            heat=_map(report, definition),
            most_drives=most_drives(report),
            steps=range(1, STEPS + 1),
            timeline=timeline_of(report),
            throughput=Markup(chart),  # noqa: S704
            throughput_most=most,
            curves=battery_curves(report),
            most_curves=MAX_BATTERIES,
            states=STATES,
            part_colors=_PART_COLORS,
            waited_for=_waited_for(report),
            most_rows=_MAX_ROWS,
        )
    )
    return Markup(body)  # noqa: S704 - escaped by the template


def _map(report: Report, definition: Mapping[str, Any]) -> Markup:
    """Return the map of the world; an empty text if this version can't read the world."""
    try:
        world = world_of(dict(definition), "world")
    except WorldError:
        return Markup("")
    return Markup(heat_map(report, world))  # noqa: S704 - escaped by `heat_map`


def _waited_for(report: Report) -> list[tuple[str, str, int, float]]:
    """Return each robot that waited, what it waited for, how often and for how many seconds; the longest first."""
    totals: dict[tuple[str, str], tuple[int, float]] = {}
    for wait in report.waits:
        for blocker in wait.robots or (wait.why or "its turn",):
            count, duration = totals.get((wait.robot, blocker), (0, 0.0))
            totals[wait.robot, blocker] = count + 1, duration + wait.duration
    rows = [(robot, blocker, count, duration) for (robot, blocker), (count, duration) in totals.items()]
    return sorted(rows, key=lambda row: (-row[3], row[0], row[1]))
