"""``hmrsim security check``: prove that a running simulator enforces the policy."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Final

from hmrsim.cli.security_options import VARIABLE, add_json
from hmrsim.program.command_line import Later
from hmrsim.settings.arguments import add_settings
from hmrsim_zenoh.wire.options import ENVIRONMENT, SessionOptions

_EXAMPLES: Final = f"""\
exit codes:
  0  the simulator enforces the policy
  1  it does not, in the cases that are marked
  3  no simulator answers

examples:
  hmrsim security check keys
  hmrsim security check keys --connect tls/10.0.0.7:7447

{ENVIRONMENT}"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim security check``."""
    parser.description = (
        "Try at a running simulator what each enclave may and what it may not, also without a certificate, with one\n"
        "of another authority and with an expired one. Nothing is changed: all requests are unreadable on purpose."
    )
    parser.epilog = _EXAMPLES
    parser.add_argument(
        "keystore", nargs="?", type=Path, metavar="DIR", help=f"the folder of the keystore (default: {VARIABLE})"
    )
    add_settings(parser, SessionOptions, only=("connect", "timeout"))
    add_json(parser)
    parser.set_defaults(function=Later("hmrsim.cli.security_proof", "check"))
