"""A report as one self-contained HTML page: no external script, style, font or picture."""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Mapping, Sequence
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING, Any, Final

from jinja2 import Environment, FunctionLoader, StrictUndefined
from markupsafe import Markup

from hmrsim.drawing import PALETTE, THEMES
from hmrsim.errors import WorldError
from hmrsim.report import wording
from hmrsim.report.charts import MAX_BATTERIES, battery_curves, throughput_chart
from hmrsim.report.heat import STEPS, heat_map, most_drives
from hmrsim.report.model import STATES
from hmrsim.report.timeline import timeline_of
from hmrsim.trace.sections import restart_text
from hmrsim.world_checks.loading import world_of

if TYPE_CHECKING:
    from hmrsim.report.model import Report, Section

_MAX_ROWS: Final = 500
"""Maximum rows of a table; the JSON and the CSV files have all."""


def page_of(report: Report, definition: Mapping[str, Any]) -> str:
    """Return the page.

    *definition* is the world of the run, as in a native file.
    """
    return _page(report.world.name, _body(report, definition, f"Report of a {report.source.kind}"))


def page_of_sections(sections: Sequence[Section], definitions: Sequence[Mapping[str, Any]]) -> str:
    """Return the page of a trace with several sections, which lists them and then has the report of each.

    *definitions* are their worlds, as in native files.
    """
    bodies = []
    for section, definition in zip(sections, definitions, strict=True):
        why = f": {restart_text(section.cause)}" if section.cause else ""
        kind, prefix = f"Section {section.section}{why}", f"section-{section.section}-"
        bodies.append(_body(section.report, definition, kind, prefix=prefix, main="div"))
    body = _templates().get_template("sections.html").render(sections=sections, bodies=bodies)
    return _page(sections[0].report.world.name, Markup(body))  # noqa: S704 - escaped by the template


def _page(title: str, body: Markup) -> str:
    script, style = (_part(name) for name in ("page.js", "page.css"))
    page: str = (
        _templates()
        .get_template("page.html")
        .render(
            title=title,
            body=body,
            script=Markup(script),  # noqa: S704 - ours
            script_hash=base64.b64encode(hashlib.sha256(script.encode()).digest()).decode(),
            style=Markup(_colours() + style),  # noqa: S704 - ours
        )
    )
    return page


def _body(report: Report, definition: Mapping[str, Any], kind: str, *, prefix: str = "", main: str = "main") -> Markup:
    """Return a report without what surrounds it; *prefix* is that of ids, and *main* the element of its main part."""
    chart, most = throughput_chart(report.throughput)
    body: str = (
        _templates()
        .get_template("report.html")
        .render(
            kind=kind,
            prefix=prefix,
            main=main,
            report=report,
            unit=report.world.units,
            # SVG was escaped by the functions that made it.
            heat=_map(report, definition),
            most_drives=most_drives(report),
            steps=range(1, STEPS + 1),
            timeline=timeline_of(report),
            throughput=Markup(chart),  # noqa: S704
            throughput_most=most,
            curves=battery_curves(report),
            most_curves=MAX_BATTERIES,
            states=STATES,
            waited_for=_waited_for(report),
            most_rows=_MAX_ROWS,
        )
    )
    return Markup(body)  # noqa: S704 - escaped by the template


def _map(report: Report, definition: Mapping[str, Any]) -> Markup:
    """Return the map; nothing for a world that this version can't read."""
    try:
        world = world_of(dict(definition), "world")
    except WorldError:
        return Markup("")
    return Markup(heat_map(report, world))  # noqa: S704 - escaped by who made it


def _waited_for(report: Report) -> list[tuple[str, str, int, float]]:
    """Return which robots waited for what, how often and how long; the longest first."""
    found: dict[tuple[str, str], tuple[int, float]] = {}
    for wait in report.waits:
        for what in wait.robots or (wait.why or "something",):
            count, duration = found.get((wait.robot, what), (0, 0.0))
            found[wait.robot, what] = count + 1, duration + wait.duration
    rows = [(robot, what, count, duration) for (robot, what), (count, duration) in found.items()]
    return sorted(rows, key=lambda row: (-row[3], row[0], row[1]))


@cache
def _part(name: str) -> str:
    return files(__package__).joinpath(name).read_text("utf-8")


def _templates() -> Environment:
    environment = Environment(
        loader=FunctionLoader(_part), autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters |= {
        "seconds": wording.seconds,
        "amount": wording.amount,
        "share": wording.share,
        "svg": Markup,
        "restart": restart_text,
    }
    return environment


def _colours() -> str:
    """Return the palette as CSS, for both themes."""
    themes = {}
    for theme in THEMES:
        colours = {name.replace("_", "-"): colour for name, colour in PALETTE[theme].items()}
        colours |= {f"heat-{i}": colour for i, colour in enumerate(PALETTE["heat"][theme], 1)}
        themes[theme] = "".join(f"--{name}:{colour};" for name, colour in colours.items())
    states = "".join(f"--{state}:{colour};" for state, colour in PALETTE["states"].items())
    return (
        f":root{{color-scheme:light dark;{themes['light']}{states}}}\n"
        f"@media (prefers-color-scheme:dark){{:root{{{themes['dark']}}}}}\n"
        f"@media print{{:root{{color-scheme:light;{themes['light']}}}}}\n"
    )
