"""The page of a search: what was found, each failure with its story, what was tried, what was not reached."""

from __future__ import annotations

import math
import shlex
from typing import TYPE_CHECKING, NamedTuple

from markupsafe import Markup

from hmrsim import __version__
from hmrsim.fault_search.results.story import events_of, mark_of, passes
from hmrsim.report.html import page_around, part, templates

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from hmrsim.fault_search.file.check import Check
    from hmrsim.fault_search.results.finding import Finding
    from hmrsim.fault_search.results.summary import Summary


class _Line(NamedTuple):
    """An event of a story."""

    at: float
    text: str
    mark: str


class _Shown(NamedTuple):
    """What is shown of a failure."""

    finding: Finding
    file: str
    things: Sequence[tuple[str, str]]
    lines: Sequence[_Line]


def page_of(check: Check, summary: Summary, folder: Path) -> str:
    """Return the page, which needs no other file.

    Args:
        check: The check.
        summary: What came of the search.
        folder: The folder of the results, as a command line has it.
    """
    environment = templates(__package__)
    environment.filters |= {"count": "{:,}".format, "margin": _margin}
    body: str = environment.get_template("check.html").render(
        summary=summary,
        version=__version__,
        controller=_controller(check),
        shown=[_shown(each, summary.files.get(number, "")) for number, each in enumerate(summary.findings, 1)],
        folder=shlex.quote(str(folder)),
        tried=sorted(summary.tried.kinds),
        failed={each.failure.property for each in summary.findings},
        verdicts={verdict.property: verdict for verdict in summary.nominal.verdicts},
    )
    whole = Markup(body)  # noqa: S704 - escaped by the template
    return page_around(f"Check of {summary.name}", whole, style=part("check.css", __package__))


def _controller(check: Check) -> str:
    treatment = check.treatment
    command = treatment.command
    said = treatment.tree or treatment.python or (command if isinstance(command, str) else shlex.join(command or ()))
    return str(said)


def _shown(finding: Finding, file: str) -> _Shown:
    things = [(thing.describe(), passes(outcome)) for thing, outcome in finding.in_order]
    return _Shown(finding, file, things, [_Line(at, text, mark_of(text)) for at, text in events_of(finding.told)])


def _margin(robustness: float) -> str:
    return f"{robustness:+.3g}" if math.isfinite(robustness) else "-"
