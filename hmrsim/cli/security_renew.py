"""``hmrsim security renew``: make new certificates."""

from __future__ import annotations

import argparse

from hmrsim.cli.security_options import add_days, add_json, add_keystore
from hmrsim.program.command_line import Later


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim security renew``."""
    parser.description = (
        "Make new certificates and keys, before the old ones expire. The old ones stay valid until then."
    )
    add_keystore(parser)
    parser.add_argument("names", nargs="*", metavar="NAME", help="the enclaves to renew (default: all)")
    add_days(parser)
    add_json(parser)
    parser.set_defaults(function=Later("hmrsim.cli.security_store", "renew"))
