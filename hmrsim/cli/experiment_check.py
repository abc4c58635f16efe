"""``hmrsim experiment check``: everything that is wrong with an experiment."""

from __future__ import annotations

import argparse
from typing import Final

from hmrsim.cli.experiment_options import add_file
from hmrsim.program.command_line import Later

_EXAMPLES: Final = """\
exit codes: 0 no errors, maybe warnings; 2 errors

examples:
  hmrsim experiment check delivery.yaml
  hmrsim experiment check delivery.yaml --variant flaky"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim experiment check``."""
    parser.description = (
        "List everything that is wrong with an experiment: its file, the world of each scenario, its controllers,\n"
        "measures and endings. Nothing is run."
    )
    parser.epilog = _EXAMPLES
    add_file(parser)
    parser.add_argument("--json", action="store_true", help="print one JSON object with what will be run")
    parser.set_defaults(function=Later("hmrsim.cli.experiment_campaign", "check"))
