"""The options of a command that connects to a simulator."""

from __future__ import annotations

import argparse

from hmrsim.program.log_options import add_log_options
from hmrsim_zenoh.wire.options import add_session_options


def add_connection_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that `connected` reads: the simulator's endpoint, and the log level."""
    add_session_options(parser)
    add_log_options(parser)
