"""``hmrsim experiment export``: the table of runs for other programs."""

from __future__ import annotations

import argparse
from pathlib import Path

from hmrsim.cli.experiment_options import add_results
from hmrsim.program.command_line import Later


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim experiment export``."""
    parser.description = (
        "Write the table of runs, a row each. The results themselves are SQLite, which pandas and polars read, too:\n"
        "pandas.read_sql('SELECT * FROM runs', sqlite3.connect('results/results.sqlite'))"
    )
    parser.epilog = (
        "examples:\n  hmrsim experiment export results -o runs.csv\n"
        "  hmrsim experiment export results -o runs.parquet\n"
        "  hmrsim experiment export results --json | jq '.[0]'"
    )
    add_results(parser)
    parser.add_argument(
        "-o", "--output", metavar="FILE", type=Path, help="ends in .csv, .json or .parquet (CSV to standard output)"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON list")
    parser.set_defaults(function=Later("hmrsim.cli.experiment_tables", "export"))
