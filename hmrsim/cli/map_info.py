"""``hmrsim map info``: the contents of a world file."""

from __future__ import annotations

import argparse
from typing import Final

from hmrsim.cli.options import add_world_options
from hmrsim.program.command_line import ENVIRONMENT, Later

_EXAMPLES: Final = f"""\
examples:
  hmrsim map info hospital
  hmrsim map info drawing.drawio --json | jq '.counts, .parts'
  hmrsim map info a.yaml --json | jq -r .hash
  hmrsim map info warehouse --json | jq '.network.bottlenecks.worst[0]'

{ENVIRONMENT}"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim map info``."""
    parser.description = (
        "Show the contents of a world file, and what its lanes mean for traffic: bottlenecks, places that can't be"
        " reached, the longest and shortest trips, and where traffic will concentrate."
    )
    parser.epilog = _EXAMPLES
    add_world_options(parser, argument="file")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.set_defaults(function=Later("hmrsim.cli.map_facts", "info"))
