"""``hmrsim map plan``: the route between two places, and its travel time."""

from __future__ import annotations

import argparse
from typing import Final

from hmrsim.cli import options
from hmrsim.cli.options import add_world_options
from hmrsim.program.command_line import ENVIRONMENT, Later

_EXAMPLES: Final = f"""\
exit codes: 0 there is a route; 1 there is none, or no such name; 2 the file can't be read

examples:
  hmrsim map plan hospital wall_e pharmacy
  hmrsim map plan hospital lab 39,6.5 --for eve
  hmrsim map plan my_world.yaml home -3,4 --speed 0.8 --json | jq .length

{ENVIRONMENT}"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim map plan``."""
    parser.description = "Print the quickest route from one point to another, each of its legs, and its travel time."
    parser.epilog = _EXAMPLES
    add_world_options(parser, argument="file")
    where = "X,Y, or the name of a waypoint, place, dock, robot or item"
    parser.add_argument("start", metavar="FROM", help=where)
    parser.add_argument("goal", metavar="TO", help=where)
    who = parser.add_mutually_exclusive_group()
    who.add_argument(
        "--for", dest="driver", metavar="ROBOT", help="the robot that drives (default: FROM, if that is a robot)"
    )
    who.add_argument(
        "--speed",
        type=options.positive,
        metavar="V",
        help="the maximum speed, in the world's unit per second (default: that of a robot without one)",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.set_defaults(function=Later("hmrsim.cli.map_trip", "plan"))
