"""``hmrsim view``: show a simulation, live or recorded, in a browser."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Final

from hmrsim.program.command_line import Later
from hmrsim.program.log_options import add_log_options
from hmrsim_zenoh.view import DEFAULT_HOST, DEFAULT_PORT
from hmrsim_zenoh.wire.options import ENVIRONMENT, add_session_options

_EXAMPLES: Final = f"""\
examples:
  hmrsim view --open
  hmrsim view --connect tcp/10.0.0.7:7447 --port 8080
  hmrsim view --host 0.0.0.0
  hmrsim view shift.mcap

{ENVIRONMENT}"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim view``."""
    parser.description = (
        "Serve a page that shows a simulator live, or plays a recording, until Ctrl-C. Prints `ready URL`.\n"
        "The simulator may be on another machine; when it is restarted, the page continues with it."
    )
    parser.epilog = _EXAMPLES
    parser.add_argument(
        "recording",
        nargs="?",
        type=Path,
        metavar="RECORDING.mcap",
        help="play this recording instead of showing a simulator",
    )
    group = parser.add_argument_group("page")
    group.add_argument(
        "--host",
        default=DEFAULT_HOST,
        metavar="ADDRESS",
        help="address to serve on; if not local, the URL has a token that every page needs (default: %(default)s)",
    )
    group.add_argument(
        "--port",
        type=Later("hmrsim.cli.view_page", "port"),
        default=DEFAULT_PORT,
        metavar="PORT",
        help="… 0 for a free one (default: %(default)s)",
    )
    group.add_argument("--open", action="store_true", help="open the page in the browser")
    add_session_options(parser)
    add_log_options(parser)
    parser.add_argument("--json", action="store_true", help="print that it is ready as one JSON object")
    parser.set_defaults(function=Later("hmrsim.cli.view_page", "serve"))
