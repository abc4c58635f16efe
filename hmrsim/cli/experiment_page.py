"""The results of an experiment as one page, or as JSON."""

from __future__ import annotations

import argparse
import shlex
from pathlib import Path
from typing import Final

from hmrsim.cli.exits import ExitCode, WrongUse
from hmrsim.cli.output import show, show_json
from hmrsim.experiments.report import page_of, summary_of
from hmrsim.experiments.results.store import FILE, Results
from hmrsim.program.outputs import STDOUT, check_outputs, unwritable

_PAGE: Final = "report.html"
"""The name of the page in the folder of results, if no other is given."""


def report(args: argparse.Namespace) -> int:
    """Write the page of an experiment's results, or print what is on it; return the exit code."""
    if args.json and args.output == STDOUT:
        raise WrongUse("hmrsim experiment report: -o - and --json both write to the standard output; give -o a file")
    output = args.output or (None if args.json else str(args.results / _PAGE))
    check_outputs([("-o", output)], [args.results / f"{FILE}{end}" for end in ("", "-wal", "-shm")])
    with Results(args.results) as results:
        summary = summary_of(results)
    if output == STDOUT:
        show(page_of(summary, shlex.quote(str(args.results))))
    elif output is not None:
        _write(output, page_of(summary, shlex.quote(str(args.results))))
        if not args.json:
            show(f"page: {output}")
    if args.json:
        show_json(summary.model_dump(mode="json"))
    return ExitCode.DONE


def _write(output: str, page: str) -> None:
    try:
        Path(output).write_text(page, encoding="utf-8", newline="\n")
    except OSError as error:
        raise unwritable(f"-o {output}", error) from None
