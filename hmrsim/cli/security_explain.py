"""``hmrsim security explain``: who may do what on a key, and by which rule."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Final

from hmrsim.cli.security_options import add_json
from hmrsim.program.command_line import Later

_EXAMPLES: Final = """\
examples:
  hmrsim security explain keys hmrsim/wall_e/wait/_action/send_goal
  hmrsim security explain keys hmrsim/_world/load_world viewer
  hmrsim security explain keys '0/wall_e/**' operator"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim security explain``."""
    parser.description = (
        "Say who may do what on a key or a key expression, and by which rule of the policy. To ask is to get a value,\n"
        "to send a goal or to call a service."
    )
    parser.epilog = _EXAMPLES
    parser.add_argument("keystore", type=Path, metavar="DIR", help="a keystore, or one enclave of it")
    parser.add_argument("key", metavar="KEY", help="a key expression, such as hmrsim/wall_e/odom")
    parser.add_argument("name", nargs="?", metavar="ROLE", help="an enclave, by name or role (default: all)")
    add_json(parser)
    parser.set_defaults(function=Later("hmrsim.cli.security_rules", "explain"))
