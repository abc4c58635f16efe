"""``hmrsim map validate``: everything that is wrong with a world file."""

from __future__ import annotations

import argparse
from typing import Final

from hmrsim.cli.options import add_world_options
from hmrsim.program.command_line import ENVIRONMENT, Later

_EXAMPLES: Final = f"""\
exit codes: 0 no errors, maybe warnings; 1 errors; 2 the file, or an option, can't be read

examples:
  hmrsim map validate my_world.yaml
  hmrsim map validate my_world.yaml --traffic
  hmrsim map validate my_world.yaml --json | jq -r '.[].message'

{ENVIRONMENT}"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim map validate``."""
    parser.description = "List everything that is wrong with a world file, and what looks odd."
    parser.epilog = _EXAMPLES
    add_world_options(parser, argument="file")
    parser.add_argument(
        "--traffic",
        action="store_true",
        help="also warn of places and starts where robots will be in the way of others under the traffic policy, of"
        " corridors in which they block each other for good, and of too few places to wait",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON list")
    parser.set_defaults(function=Later("hmrsim.cli.map_problems", "validate"))
