"""``hmrsim security revoke``: take all rights from an enclave."""

from __future__ import annotations

import argparse

from hmrsim.cli.security_options import add_json, add_keystore
from hmrsim.program.command_line import Later


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim security revoke``."""
    parser.description = (
        "Take all rights from an enclave, as when its key is lost. A simulator that is running, and a page\n"
        "that is served, know the old policy: restart them."
    )
    add_keystore(parser)
    parser.add_argument("name", metavar="NAME", help="the enclave")
    add_json(parser)
    parser.set_defaults(function=Later("hmrsim.cli.security_store", "revoke"))
