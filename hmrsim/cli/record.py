"""``hmrsim record``: record a simulator's publications to a file, over the network."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import Final

from hmrsim.cli import options
from hmrsim.cli.options import add_connection_options
from hmrsim.program.command_line import Later
from hmrsim_zenoh.wire.options import ENVIRONMENT

_EXAMPLES: Final = f"""\
examples:
  hmrsim record run.mcap
  hmrsim record run.mcap --duration 60 --connect tcp/10.0.0.7:7447
  hmrsim record run.mcap && hmrsim view run.mcap

{ENVIRONMENT}"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim record``."""
    parser.description = (
        "Record everything that a simulator publishes to an MCAP file until Ctrl-C, or until the simulator is gone."
    )
    parser.epilog = _EXAMPLES
    parser.add_argument("file", type=Path, metavar="OUT.mcap", help="an existing file is overwritten")
    parser.add_argument(
        "--duration",
        type=options.positive,
        default=math.inf,
        metavar="S",
        help="end after this many simulated seconds (default: never)",
    )
    parser.add_argument("--json", action="store_true", help="print how much was recorded as one JSON object")
    add_connection_options(parser)
    parser.set_defaults(function=Later("hmrsim.cli.record_file", "record"))
