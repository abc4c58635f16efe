"""``hmrsim experiment status``: how far an experiment is."""

from __future__ import annotations

import argparse

from hmrsim.cli.experiment_options import add_results
from hmrsim.program.command_line import Later


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim experiment status``."""
    parser.description = (
        "Show how many runs of an experiment have a result, and how they have ended; also while it runs."
    )
    parser.epilog = (
        "examples:\n  hmrsim experiment status results\n  hmrsim experiment status results --json | jq .endings"
    )
    add_results(parser)
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.set_defaults(function=Later("hmrsim.cli.experiment_tables", "status"))
