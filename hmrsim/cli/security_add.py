"""``hmrsim security add``: add an enclave to a keystore."""

from __future__ import annotations

import argparse
from typing import Final

from hmrsim.cli.security_options import add_days, add_json, add_keystore
from hmrsim.program.command_line import Later

_EXAMPLES: Final = """\
examples:
  hmrsim security add keys viewer lobby
  hmrsim security add keys controller porters --robot m_o --robot eve --service call_lift"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim security add``."""
    parser.description = "Add an enclave to a keystore. Simulators that start afterwards know it."
    parser.epilog = _EXAMPLES
    add_keystore(parser)
    parser.add_argument("role", choices=("controller", "viewer", "operator"), metavar="ROLE", help="%(choices)s")
    parser.add_argument("name", metavar="NAME", help="the name of the enclave")
    parser.add_argument(
        "--robot", action="append", default=[], metavar="ROBOT", help="a robot that the controller drives; repeatable"
    )
    parser.add_argument(
        "--service",
        action="append",
        default=[],
        metavar="SERVICE",
        help="a service of the world that the controller may call, such as call_lift; repeatable",
    )
    add_days(parser)
    add_json(parser)
    parser.set_defaults(function=Later("hmrsim.cli.security_store", "add"))
