"""``hmrsim doctor``: the network: what is on it, what is wrong, and what to do."""

from __future__ import annotations

import argparse
from typing import Final

from hmrsim.cli.options import add_connection_options
from hmrsim.program.command_line import Later
from hmrsim_zenoh.wire.options import ENVIRONMENT

_EXAMPLES: Final = f"""\
exit codes:
  0  no errors, maybe warnings
  1  errors; each comes with a remedy
  2  wrong use
  3  neither a simulator nor a ROS node answers

examples:
  hmrsim doctor
  hmrsim doctor --ros-domain-id 7 --connect tcp/10.0.0.7:7447
  hmrsim doctor --json | jq -r '.problems[].remedy'

{ENVIRONMENT}"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim doctor``."""
    parser.description = (
        "Show what is on the network (a simulator, its robots and their controllers, ROS nodes), what is wrong,\n"
        "and what to do. It observes for half a second, and changes nothing."
    )
    parser.epilog = _EXAMPLES
    parser.add_argument("--json", action="store_true", help="print one JSON object with everything")
    parser.add_argument(
        "--ros-domain-id",
        type=Later("hmrsim.cli.doctor_examination", "ros_domain_id"),
        metavar="N",
        help="the ROS domain to examine (default: the environment's ROS_DOMAIN_ID, else 0)",
    )
    parser.set_defaults(function=Later("hmrsim.cli.doctor_examination", "examine"))
    add_connection_options(parser)
