"""``hmrsim experiment again``: one run once more."""

from __future__ import annotations

import argparse
from pathlib import Path

from hmrsim.cli.experiment_options import add_results
from hmrsim.program.command_line import Later


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim experiment again``."""
    parser.description = "Repeat one run of an experiment in this process, and say whether it came out as before."
    parser.epilog = (
        "exit codes: 0 the same result; 1 another one; 2 there is no such run\n\n"
        "examples:\n  hmrsim experiment again results 17\n"
        "  hmrsim experiment again results 17 --trace run.jsonl --report run.html\n"
        "  hmrsim experiment again results 17 --record run.mcap && hmrsim view run.mcap"
    )
    add_results(parser)
    parser.add_argument("run", metavar="RUN", type=int, help="the number of the run")
    parser.add_argument("--trace", metavar="FILE", type=Path, help="write its trace")
    parser.add_argument("--report", metavar="FILE", type=Path, help="write its report, as one page")
    parser.add_argument("--record", metavar="FILE", type=Path, help="record it, for `hmrsim view` and Foxglove (MCAP)")
    parser.add_argument("--json", action="store_true", help="print the result as one JSON object")
    parser.set_defaults(function=Later("hmrsim.cli.experiment_repeat", "again"))
