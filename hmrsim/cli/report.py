"""``hmrsim report``: what happened in a trace or a recording, as a page, as JSON or as tables."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Final

from hmrsim.cli.options import count
from hmrsim.program.command_line import Later
from hmrsim.program.log_options import add_log_options

_EXAMPLES: Final = """\
A trace is replayed, so that each motion is known; this takes as long as `hmrsim replay`. Where this version can't
run it again, the report is of what the trace says itself, and tells what is missing.

A trace has a section for each time that a client began the simulation anew. With several, each is reported apart, and
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


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim report``."""
    parser.description = (
        "Report on a run from its trace (--trace) or its recording (--record): how goals ended\n"
        "and why, what each robot did, for whom it waited, how far it drove, where the lanes are full.\n"
        "Without -o, --json or --csv a summary is printed."
    )
    parser.epilog = _EXAMPLES
    parser.add_argument("file", type=Path, metavar="TRACE|MCAP", help="a file that --trace or --record has written")
    parser.add_argument(
        "-o", "--output", metavar="FILE", help="write a self-contained HTML page; - is the standard output"
    )
    parser.add_argument(
        "--section", type=count, metavar="N", help="report on this section of a trace only (default: on each)"
    )
    parser.add_argument("--json", action="store_true", help="print the whole report as one JSON object")
    parser.add_argument(
        "--csv",
        type=_folder,
        metavar="DIR",
        help="write tables: goals.csv with one row per goal, robots.csv, waits.csv, …",
    )
    add_log_options(parser, default="error")
    parser.set_defaults(function=Later("hmrsim.cli.report_output", "report"))


def _folder(text: str) -> Path:
    if not text:
        raise argparse.ArgumentTypeError("empty; expected a folder, such as . or tables")
    return Path(text)
