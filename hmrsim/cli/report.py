"""``hmrsim report``: what happened in a trace or a recording, as text, a page, JSON or tables."""

from __future__ import annotations

import argparse
import errno
import os
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

from hmrsim.cli.options import ExitCode, WrongUse, add_json, count
from hmrsim.cli.output import show, show_table, warn
from hmrsim.errors import TraceError, printable
from hmrsim.program.files import STDOUT, check_outputs, check_writable, unwritable, write_text
from hmrsim.program.log_options import add_log_options, logging_to_stderr

if TYPE_CHECKING:
    from hmrsim.report import Report, ReportInput, Section

_CONTROL: Final = re.compile("[\x7f-\x9f]")
"""Control characters that JSON allows in strings, but that a terminal interprets."""
_MAX_ROBOTS: Final = 40
_MAX_ERRORS: Final = 10
_MAX_CAUSES: Final = 4


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim report``."""
    parser.description = (
        "Report on a run from its trace (--trace) or its recording (--record): how goals ended\n"
        "and why, what each robot did, for whom it waited, how far it drove, where the lanes are full.\n"
        "Without -o, --json or --csv a summary is printed."
    )
    parser.epilog = """\
A trace is replayed to reconstruct each motion, which takes as long as `hmrsim replay`. If this version can't run it
again, the report uses only what is in the trace, and lists what is missing.

A trace has a section for each time that a client restarted the simulation. Each section is reported separately, and
--csv writes to a folder for each, section_1, section_2 and so on.

exit codes: 0 done, also if goals failed; 2 the file is neither a trace nor a recording, it has no such section, or the
output can't be written

examples:
  hmrsim simulate warehouse --trace run.jsonl && hmrsim report run.jsonl
  hmrsim report run.jsonl -o report.html
  hmrsim report run.jsonl --section 2
  hmrsim report shift.mcap -o report.html --csv tables
  hmrsim report run.jsonl --json | jq '.robots[] | {name, waited, waited_for}'
  python -c 'import pandas; print(pandas.read_csv("tables/goals.csv").groupby("action").duration.describe())'"""
    parser.add_argument("file", type=Path, metavar="TRACE|MCAP", help="a file written by --trace or --record")
    parser.add_argument(
        "-o", "--output", metavar="FILE", help="write a self-contained HTML page; - is the standard output"
    )
    parser.add_argument(
        "--section", type=count, metavar="N", help="report on this section of a trace only (default: on each)"
    )
    add_json(parser, "print the whole report as one JSON object")
    parser.add_argument(
        "--csv",
        type=_folder,
        metavar="DIR",
        help="write tables: goals.csv with one row per goal, robots.csv, waits.csv, …",
    )
    add_log_options(parser, default="error")
    parser.set_defaults(function=_report)


def _folder(text: str) -> Path:
    if not text:
        raise argparse.ArgumentTypeError("empty; expected a folder, such as . or tables")
    return Path(text)


def _report(args: argparse.Namespace) -> int:
    from hmrsim.program.memory import collect_rarely
    from hmrsim.report import Sections, section_of
    from hmrsim.report.tables import table_names

    if args.json and args.output == STDOUT:
        raise WrongUse("hmrsim report: -o - and --json both write to the standard output; give -o a file")
    tables = [args.csv / name for name in table_names()] if args.csv is not None else []
    check_outputs([("-o", args.output), *(("--csv", table) for table in tables)], [args.file])
    if args.output not in (None, STDOUT):
        check_writable("-o", Path(args.output))
    if args.csv is not None:
        _check_folder(args.csv)
    collect_rarely()
    with logging_to_stderr(args):
        sources = _read(args.file, args.section)
        sections = [section_of(source) for source in sources]
    for section in sections:
        where = f"section {section.section}: " if len(sections) > 1 else ""
        for note in section.report.source.notes:
            warn(f"{args.file}: {where}{printable(note)}")
    if args.output is not None:
        _write_page(args.output, sections, sources)
    if args.csv is not None:
        _write_tables(args.csv, sections, args)
    if args.json:
        printed = sections[0].report if len(sections) == 1 else Sections(sections=tuple(sections))
        show(_CONTROL.sub(lambda match: f"\\u{ord(match[0]):04x}", printed.model_dump_json()))
    elif args.output is None and args.csv is None:
        _show_text(sections, chosen=args.section is not None)
    return ExitCode.DONE


def _check_folder(directory: Path) -> None:
    """Check that a folder exists or can be created, and that files can be written in it."""
    nearest = next(each for each in (directory, *directory.parents) if each.exists())
    if not nearest.is_dir():
        raise unwritable(f"--csv {directory}", NotADirectoryError(errno.ENOTDIR, "not a directory"))
    if not os.access(nearest, os.W_OK | os.X_OK):
        raise unwritable(f"--csv {directory}", PermissionError(errno.EACCES, "permission denied"))


def _read(path: Path, section: int | None) -> list[ReportInput]:
    """Return the content of each section of a trace, or of one, or the content of a recording."""
    from hmrsim.cli.replay import errors_of, is_recording, lines_of
    from hmrsim.report import of_recording, of_trace
    from hmrsim_zenoh.recording import Recording

    with errors_of(path, no_text="neither a trace (text) nor a recording (MCAP)"):
        if is_recording(path):
            if section is not None:
                raise TraceError(f"no section {section}: a recording has none, as time continues in it after a reset")
            return [of_recording(Recording(path))]
        return of_trace(lambda: lines_of(path), section=section)


def _write_page(output: str, sections: list[Section], sources: list[ReportInput]) -> None:
    from hmrsim.report.page import page_of_sections

    page = page_of_sections(sections, [source.definition for source in sources])
    if output == STDOUT:
        show(page)
    else:
        write_text("-o", Path(output), page)


def _write_tables(directory: Path, sections: list[Section], args: argparse.Namespace) -> None:
    """Write the tables of one section to a folder, or those of several sections to subfolders."""
    from hmrsim.report.tables import table_names, tables_of

    several = len(sections) > 1
    folders = {directory / f"section_{each.section}" if several else directory: each.report for each in sections}
    tables = [("--csv", folder / name) for folder in folders for name in table_names()]
    check_outputs([("-o", args.output), *tables], [args.file])
    for folder, report in folders.items():
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise unwritable(f"--csv {folder}", error) from None
        for name, text in tables_of(report).items():
            write_text("--csv", folder / name, text)


def _show_text(sections: Sequence[Section], *, chosen: bool) -> None:
    """Print a summary of each section, preceded by a list unless the only section was not *chosen*."""
    if len(sections) == 1 and not chosen:
        _show_summary(sections[0].report)
        return
    for section in sections:
        show(_listed(section))
    for section in sections:
        show(f"\nsection {section.section}" if len(sections) > 1 else "")
        _show_summary(section.report)


def _listed(section: Section) -> str:
    from hmrsim.report.html import times
    from hmrsim.trace.sections import restart_text

    world, summary = section.report.world, section.report.summary
    seed = "" if world.seed is None else f", seed {world.seed}"
    why = f": {restart_text(section.cause)}" if section.cause else ""
    goals = times(summary.goals, "goal")
    return printable(f"section {section.section}, {world.name}{seed}, {summary.sim_time:.3f} s, {goals}{why}")


def _show_summary(report: Report) -> None:
    for line in _lines(report):
        show(line)
    if report.robots:
        show("")
        headings = ("robot", "succeeded", "failed", "driven", "driving", "waiting", "idle", "waited", "mostly for")
        show_table(headings, _robots(report), left=("robot", "mostly for"))
        if len(report.robots) > _MAX_ROBOTS:
            show(f"… and {len(report.robots) - _MAX_ROBOTS} more; see --json or --csv")
    if report.errors:
        show("")
    for error in report.errors[:_MAX_ERRORS]:
        code = error.error_name if error.error_code is None else f"{error.error_code} {error.error_name}".strip()
        while_waiting = (
            f"; it waited for {error.waited_for}"
            if error.waited_for and error.waited_for not in error.error_msg
            else ""
        )
        line = (
            f"{error.at:.1f} s  {error.robot} {error.action} {error.status}: {error.error_msg} ({code}){while_waiting}"
        )
        show(printable(line))
    if len(report.errors) > _MAX_ERRORS:
        show(f"… and {len(report.errors) - _MAX_ERRORS} more errors; see --json or --csv")


def _lines(report: Report) -> Iterator[str]:
    from hmrsim.report.html import amount, parts, seconds, share, times

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
    if report.first_causes:
        causes = (f"{seconds(each.seconds)} {each.cause} ({each.state})" for each in report.first_causes[:_MAX_CAUSES])
        yield printable(f"waits were started by: {'; '.join(causes)}")
    if summary.energy_used is not None:
        yield f"energy used {amount(summary.energy_used)}, charged {amount(summary.energy_charged)}"
    if (demand := report.demand) is not None:
        ended = f"{demand.delivered} delivered, {demand.late} late, {demand.lost} lost, {demand.open} open"
        lead = f"; lead time {seconds(demand.lead_time_p50)} (median), {seconds(demand.lead_time_p95)} (95 %)"
        yield f"orders: {demand.placed} placed, {ended}{lead if demand.delivered else ''}"
        if demand.delay is not None:
            yield f"lead time: {parts(demand.delay.model_dump())}"
    counts = {"deadlock": summary.deadlocks, "fault": summary.faults, "error": len(report.errors)}
    yield ", ".join(times(count, what) for what, count in counts.items())


def _robots(report: Report) -> Iterator[tuple[str, ...]]:
    from hmrsim.report.html import UNKNOWN, amount, seconds, share

    for robot in report.robots[:_MAX_ROBOTS]:
        counts = str(robot.succeeded), str(robot.failed), amount(robot.distance, report.world.units)
        shares = (share(robot.share[state]) for state in ("driving", "waiting", "idle"))
        waited = seconds(robot.waited + robot.queued) if robot.waits else UNKNOWN
        yield robot.name, *counts, *shares, waited, next(iter(robot.waited_for), "")
