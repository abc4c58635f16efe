"""A report in a few lines, for a terminal."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Final

from rich.console import Console
from rich.table import Table
from rich.text import Text

from hmrsim.cli.output import show
from hmrsim.errors import printable
from hmrsim.report.html import UNKNOWN, amount, seconds, share, times
from hmrsim.trace.sections import restart_text

if TYPE_CHECKING:
    from hmrsim.report import Report, Section

_MAX_ROBOTS: Final = 40
_MAX_ERRORS: Final = 10
_WIDTH: Final = 200
"""The width in characters of a table whose output is not a terminal."""


def show_sections(sections: Sequence[Section]) -> None:
    """Print which sections of a trace these are, a line each, and then a summary of each."""
    for section in sections:
        show(_listed(section))
    for section in sections:
        show(f"\nsection {section.section}" if len(sections) > 1 else "")
        show_summary(section.report)


def _listed(section: Section) -> str:
    world, summary = section.report.world, section.report.summary
    seed = "" if world.seed is None else f", seed {world.seed}"
    why = f": {restart_text(section.cause)}" if section.cause else ""
    goals = times(summary.goals, "goal")
    return printable(f"section {section.section}, {world.name}{seed}, {summary.sim_time:.3f} s, {goals}{why}")


def show_summary(report: Report) -> None:
    """Print a summary."""
    for line in _lines(report):
        show(line)
    if report.robots:
        show("")
        Console(width=None if Console().is_terminal else _WIDTH).print(_robots(report))
        if len(report.robots) > _MAX_ROBOTS:
            show(f"… and {len(report.robots) - _MAX_ROBOTS} more; see --json or --csv")
    if report.errors:
        show("")
    for error in report.errors[:_MAX_ERRORS]:
        code = error.error_name if error.error_code is None else f"{error.error_code} {error.error_name}".strip()
        while_waiting = f"; it waited for {error.waited_for}" if error.waited_for else ""
        line = (
            f"{error.at:.1f} s  {error.robot} {error.action} {error.status}: {error.error_msg} ({code}){while_waiting}"
        )
        show(printable(line))
    if len(report.errors) > _MAX_ERRORS:
        show(f"… and {len(report.errors) - _MAX_ERRORS} more errors; see --json or --csv")


def _lines(report: Report) -> Iterator[str]:
    summary, unit = report.summary, report.world.units
    robots = times(summary.robots, "robot")
    seed = "" if report.world.seed is None else f", seed {report.world.seed}"
    yield printable(f"{report.world.name}: {robots}, {summary.sim_time:.3f} simulated seconds{seed}")
    ended = ", ".join(f"{count} {status}" for status, count in summary.by_status.items()) or "none"
    rejected = f"; {summary.rejected} rejected" if summary.rejected else ""
    rate = "" if summary.success_rate is None else f" ({share(summary.success_rate)} of those that ended succeeded)"
    yield f"goals: {ended}{rate}{rejected}"
    waited = f"waited {seconds(summary.waited)} in {times(summary.waits, 'wait')}"
    yield f"driven {amount(summary.distance, unit)}, {waited}, {times(summary.reroutes, 'time')} replanned"
    if summary.energy_used is not None:
        yield f"energy used {amount(summary.energy_used)}, charged {amount(summary.energy_charged)}"
    if (demand := report.demand) is not None:
        ended = f"{demand.delivered} delivered, {demand.late} late, {demand.lost} lost, {demand.open} open"
        lead = f"; lead time {seconds(demand.lead_time_p50)} (median), {seconds(demand.lead_time_p95)} (95 %)"
        yield f"orders: {demand.placed} placed, {ended}{lead if demand.delivered else ''}"
    counts = {"deadlock": summary.deadlocks, "fault": summary.faults, "error": len(report.errors)}
    yield ", ".join(times(count, what) for what, count in counts.items())


def _robots(report: Report) -> Table:
    table = Table(box=None, pad_edge=False)
    for heading in ("robot", "succeeded", "failed", "driven", "driving", "waiting", "idle", "waited", "mostly for"):
        table.add_column(heading, justify="left" if heading in ("robot", "mostly for") else "right")
    for robot in report.robots[:_MAX_ROBOTS]:
        shares = [share(robot.share[state]) for state in ("driving", "waiting", "idle")]
        waited = seconds(robot.waited + robot.queued) if robot.waits else UNKNOWN
        mostly = Text(printable(next(iter(robot.waited_for), "")))
        counts = str(robot.succeeded), str(robot.failed), amount(robot.distance, report.world.units)
        table.add_row(Text(printable(robot.name)), *counts, *shares, waited, mostly)
    return table
