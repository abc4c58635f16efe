"""``hmrsim security create``: make a keystore."""

from __future__ import annotations

import argparse
from typing import Final

from hmrsim.cli.security_options import add_days, add_json, add_keystore
from hmrsim.program.command_line import ENVIRONMENT, Later
from hmrsim_zenoh.wire.keys import DEFAULT_PREFIX

_EXAMPLES: Final = f"""\
examples:
  hmrsim security create keys
  hmrsim security create keys --host 10.0.0.7 --host sim.example.org --days 30
  hmrsim security create keys --controller nurses=wall_e,eve --controller porters=m_o

{ENVIRONMENT}"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim security create``."""
    parser.description = (
        "Make a keystore: a certificate authority, and enclaves for the simulator, a controller of all robots (or\n"
        "those that --controller names), a viewer, who only reads, and an operator, who may do everything."
    )
    parser.epilog = _EXAMPLES
    add_keystore(parser)
    parser.add_argument(
        "--controller",
        action="append",
        type=Later("hmrsim.cli.security_store", "controller"),
        metavar="NAME[=ROBOT,…]",
        help="a controller, and the robots that it drives (all if none is named); repeatable",
    )
    parser.add_argument(
        "--host",
        action="append",
        default=[],
        metavar="HOST",
        help="a name or address at which the simulator is reached, beside localhost and this machine's name; "
        "repeatable, the first is in the configuration of ROS nodes",
    )
    add_days(parser)
    parser.add_argument(
        "--prefix", default=DEFAULT_PREFIX, metavar="KEY", help="prefix of the simulator's keys (default: %(default)s)"
    )
    parser.add_argument(
        "--ros-domain-id",
        type=Later("hmrsim.cli.doctor_examination", "ros_domain_id"),
        metavar="N",
        help="the ROS domain of ROS clients (default: the environment's ROS_DOMAIN_ID, else 0)",
    )
    parser.add_argument("--force", action="store_true", help="replace a keystore that exists")
    add_json(parser)
    parser.set_defaults(function=Later("hmrsim.cli.security_store", "create"))
