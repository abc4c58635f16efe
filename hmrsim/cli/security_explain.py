"""``hmrsim security explain``: who may do what on a key, and by which rule."""

from __future__ import annotations

import argparse
from typing import Final

from hmrsim.cli.security_options import VARIABLE, add_json
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
    parser.usage = f"{parser.prog} [-h] [--json] [DIR] KEY [ROLE]"
    parser.add_argument(
        "words",
        nargs="+",
        metavar="DIR KEY ROLE",
        help=f"a keystore, or one enclave of it (default: {VARIABLE}); a key expression, such as hmrsim/wall_e/odom; "
        "an enclave, by name or role (default: all)",
    )
    add_json(parser)
    parser.set_defaults(function=Later("hmrsim.cli.security_rules", "explain"))
