"""``hmrsim experiment show``: the results of an experiment, or of one run."""

from __future__ import annotations

import argparse

from hmrsim.cli.experiment_options import add_results
from hmrsim.program.command_line import Later


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim experiment show``."""
    parser.description = (
        "Show rates and means of each treatment with 95 % confidence intervals, and the runs without success; or all\n"
        "that is known of one run. The means of a treatment are those over all levels of all factors; --by has a row\n"
        "for each level."
    )
    parser.epilog = (
        "examples:\n"
        "  hmrsim experiment show results\n"
        "  hmrsim experiment show results --by robots\n"
        "  hmrsim experiment show results 17"
    )
    add_results(parser)
    parser.add_argument("run", metavar="RUN", type=int, nargs="?", help="the number of a run")
    parser.add_argument(
        "--by", metavar="FACTOR", action="append", default=[], help="a row for each level of a factor; may be repeated"
    )
    parser.add_argument("--file", action="store_true", help="print the file of the experiment as it was")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.set_defaults(function=Later("hmrsim.cli.experiment_tables", "show"))
