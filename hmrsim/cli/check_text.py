"""What ``hmrsim check`` prints."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from typing import TYPE_CHECKING, Final

from hmrsim.fault_search.results.story import passes

if TYPE_CHECKING:
    from pathlib import Path

    from hmrsim.fault_search.results.summary import Finding, Summary
    from hmrsim.fault_search.searching.campaign import Progress


_ENOUGH: Final = 500
"""Runs that are a search worth its name."""
_MINUTES: Final = 120.0
"""From so many seconds on a time is told in minutes."""


def progress_text(progress: Progress) -> str:
    """Return how far a search is, on one line."""
    tried = progress.search.tried
    pace = tried.runs / progress.seconds if progress.seconds else 0.0
    singles = tried.singles - tried.singles_left
    found = len(progress.findings)
    if progress.reducing:
        made = f"{progress.reduced_in:,} runs, at most {progress.left:.0f} s more"
        return f"reducing a failure of {progress.reducing}: {made}"
    return (
        f"searching: {tried.runs:,} runs, {pace:.0f}/s, {found} failure{'s' * (found != 1)}, "
        f"{singles:,} of {tried.singles:,} single things, {len(progress.search.guide.features):,} features, "
        f"{progress.left:.0f} s left"
    )


def summary_text(summary: Summary, folder: Path) -> Iterator[str]:
    """Yield the lines that sum up a search."""
    tried, count = summary.tried, len(summary.findings)
    what = f"{count} failure{'s' * (count != 1)}" if count else "no failure"
    pace = tried.runs / summary.seconds if summary.seconds else 0.0
    ended = "" if summary.complete else ", interrupted"
    yield f"{summary.name}: {what} in {tried.runs:,} runs ({summary.seconds:.1f} s, {pace:,.1f} runs/s{ended})"
    for number, finding in enumerate(summary.findings, 1):
        yield ""
        yield from _finding(number, finding, summary.files.get(number, ""))
    yield ""
    singles = tried.singles - summary.unreached.singles
    yield f"tried: {singles:,} of {tried.singles:,} single things at their moments, and schedules of several"
    if summary.covered:
        yield f"of the tree: {summary.covered}; see `bt-controller coverage {folder / 'coverage.json'}`"
    if tried.gave_up and summary.nominal.ending == "succeeded":
        first = "; ".join(summary.gave_up_first)
        share = f"{tried.gave_up:,} of {tried.transient:,}"
        yield f"gave up in {share} schedules with transient faults only, first: {first}"
    if summary.too_few:
        yield _too_few(summary)
    if summary.unreached.untried and not summary.too_few:
        yield f"not tried: {', '.join(summary.unreached.untried)}"
    if summary.unreached.kinds:
        yield f"never began: {', '.join(summary.unreached.kinds)}"
    if summary.unreached.properties:
        yield f"never exercised: {', '.join(summary.unreached.properties)}"
    yield f"report: {folder / 'report.html'}"


def _too_few(summary: Summary) -> str:
    """Return that there were far too few runs, and why."""
    tried, unreached = summary.tried, summary.unreached
    each = summary.seconds / max(1, tried.runs)
    text = f"{tried.runs:,} runs in {_time(summary.seconds)} are far too few for this mission ({each:.2g} s each)"
    if unreached.untried:
        text += f"; {len(unreached.untried)} kinds of things had no turn"
    return f"{text}; allow it {_time(each * _ENOUGH)} or more"


def _time(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < _MINUTES else f"{seconds / 60:.0f} minutes"


def _finding(number: int, finding: Finding, file: str) -> Iterator[str]:
    yield f"{number}. {finding.failure.property}: {finding.text}"
    if not finding.schedule:
        yield "   It fails without any fault."
    for thing, outcome in finding.in_order:
        yield f"   - {thing.describe()}"
        yield f"     without it {passes(outcome)}"
    if file:
        yield f"   hmrsim check --repro {shlex.quote(file)}"
