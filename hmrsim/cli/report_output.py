"""What ``hmrsim report`` does: it reads a trace or a recording, and writes the report."""

from __future__ import annotations

import argparse
import errno
import os
import re
from pathlib import Path
from typing import TYPE_CHECKING, Final

from hmrsim.cli.exits import ExitCode, WrongUse
from hmrsim.cli.output import show, warn
from hmrsim.cli.trace_file import errors_of, is_recording, lines_of
from hmrsim.errors import TraceError, printable
from hmrsim.program.log_options import logging_to_stderr
from hmrsim.program.memory import collect_rarely
from hmrsim.program.outputs import STDOUT, check_outputs, unwritable
from hmrsim.report import Sections, of_recording, of_trace, section_of
from hmrsim.report.page import page_of, page_of_sections
from hmrsim.report.tables import table_names, tables_of
from hmrsim_zenoh.recording import open_recording

if TYPE_CHECKING:
    from hmrsim.report import Report, ReportInput, Section

_CONTROL: Final = re.compile("[\x7f-\x9f]")
"""Control characters that JSON allows in texts; a terminal acts on them."""


def report(args: argparse.Namespace) -> int:
    """Write the report of a run as the options say; return the exit code."""
    if args.json and args.output == STDOUT:
        raise WrongUse("hmrsim report: -o - and --json both write to the standard output; give -o a file")
    tables = [args.csv / name for name in table_names()] if args.csv is not None else []
    check_outputs([("-o", args.output), *(("--csv", table) for table in tables)], [args.file])
    if args.output not in (None, STDOUT):
        _check_writable(Path(args.output))
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
        _write_all_tables(args.csv, sections, args)
    if args.json:
        _show_json(sections)
    elif args.output is None and args.csv is None:
        _show_text(sections, chosen=args.section is not None)
    return ExitCode.DONE


def _show_json(sections: list[Section]) -> None:
    printed = sections[0].report if len(sections) == 1 else Sections(sections=tuple(sections))
    show(_CONTROL.sub(lambda found: f"\\u{ord(found[0]):04x}", printed.model_dump_json()))


def _show_text(sections: list[Section], *, chosen: bool) -> None:
    # Loads rich, which takes 60 ms and is needed for text output only.
    from hmrsim.cli.report_text import show_sections, show_summary

    if len(sections) == 1 and not chosen:
        show_summary(sections[0].report)
    else:
        show_sections(sections)


def _check_folder(directory: Path) -> None:
    """Check that a folder exists or can be created, and that files can be written in it.

    Raises:
        OutputError: They can't.
    """
    nearest = next(each for each in (directory, *directory.parents) if each.exists())
    if not nearest.is_dir():
        raise unwritable(f"--csv {directory}", NotADirectoryError(errno.ENOTDIR, "not a directory"))
    if not os.access(nearest, os.W_OK | os.X_OK):
        raise unwritable(f"--csv {directory}", PermissionError(errno.EACCES, "permission denied"))


def _check_writable(output: Path) -> None:
    """Check, before a long run is replayed, that a page can be written there.

    Raises:
        OutputError: It can't.
    """
    try:
        there = output.exists()
        output.open("ab").close()
    except OSError as error:
        raise unwritable(f"-o {output}", error) from None
    if not there:
        output.unlink()


def _read(path: Path, section: int | None) -> list[ReportInput]:
    """Return the content of each section of a trace, or of one, or the content of a recording.

    Raises:
        TraceError: It can't be read, is neither a trace nor a recording, or has no such section.
    """
    with errors_of(path, no_text="neither a trace (text) nor a recording (MCAP)"):
        if is_recording(path):
            if section is not None:
                raise TraceError(f"no section {section}: a recording has none, as time continues in it after a reset")
            return [of_recording(open_recording(path))]
        return of_trace(lambda: lines_of(path), section=section)


def _write_page(output: str, sections: list[Section], sources: list[ReportInput]) -> None:
    definitions = [source.definition for source in sources]
    several = len(sections) > 1
    page = page_of_sections(sections, definitions) if several else page_of(sections[0].report, definitions[0])
    if output == STDOUT:
        show(page)
    else:
        _write(Path(output), page, "-o")


def _write_all_tables(directory: Path, sections: list[Section], args: argparse.Namespace) -> None:
    """Write the tables of one section there, those of several to folders of their own."""
    if len(sections) == 1:
        _write_tables(directory, sections[0].report)
        return
    folders = {directory / f"section_{section.section}": section.report for section in sections}
    tables = [("--csv", folder / name) for folder in folders for name in table_names()]
    check_outputs([("-o", args.output), *tables], [args.file])
    for folder, report in folders.items():
        _write_tables(folder, report)


def _write_tables(directory: Path, report: Report) -> None:
    try:
        directory.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise unwritable(f"--csv {directory}", error) from None
    for name, text in tables_of(report).items():
        _write(directory / name, text, "--csv")


def _write(path: Path, text: str, option: str) -> None:
    try:
        path.write_text(text, encoding="utf-8", newline="\n")
    except OSError as error:
        raise unwritable(f"{option} {path}", error) from None
