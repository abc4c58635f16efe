"""The options of every command that opens a session.

On a :class:`~hmrsim.program.command_line.CommandParser` ``HMRSIM_CONNECT`` and its like stand for them, too.
"""

from __future__ import annotations

import argparse
import math
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Final

from hmrsim.program.command_line import ENVIRONMENT
from hmrsim_zenoh.errors import BadOptions
from hmrsim_zenoh.wire.endpoints import check_endpoint
from hmrsim_zenoh.wire.keys import DEFAULT_PREFIX, Keys

if TYPE_CHECKING:
    from hmrsim_zenoh.wire.session import SessionOptions

__all__ = ["ENVIRONMENT", "add_session_options", "seconds", "session_options"]

_MODES: Final = ("peer", "client", "router")


def add_session_options(parser: argparse.ArgumentParser) -> None:
    """Give a command the options that say where the simulator is."""
    group = parser.add_argument_group("session")
    group.add_argument(
        "--connect",
        action="append",
        type=partial(_endpoint, "--connect"),
        metavar="ENDPOINT",
        help="connect there, such as tcp/10.0.0.7:7447; repeatable (default: tcp/127.0.0.1:7447)",
    )
    group.add_argument(
        "--listen",
        action="append",
        type=partial(_endpoint, "--listen"),
        metavar="ENDPOINT",
        help="listen there; repeatable",
    )
    group.add_argument("--mode", choices=_MODES, help="Zenoh's mode")
    group.add_argument(
        "--zenoh-config",
        type=Path,
        metavar="FILE.json5",
        help="a configuration of Zenoh's; options come first",
    )
    group.add_argument(
        "--prefix",
        type=_prefix,
        default=DEFAULT_PREFIX,
        metavar="KEY",
        help="what all keys begin with (default: %(default)s)",
    )
    group.add_argument(
        "--timeout",
        type=seconds,
        default=5.0,
        metavar="S",
        help="wall seconds to reach a simulator (default: %(default)g)",
    )


def session_options(args: argparse.Namespace) -> SessionOptions:
    """Return what the command line and the environment say."""
    # Zenoh takes longer to load than --help may.
    from hmrsim_zenoh.wire.session import SessionOptions  # noqa: PLC0415

    return SessionOptions(
        connect=tuple(args.connect or ()),
        listen=tuple(args.listen or ()),
        mode=args.mode,
        config_file=args.zenoh_config,
        prefix=args.prefix,
        timeout=args.timeout,
    )


def _endpoint(flag: str, text: str) -> str:
    try:
        check_endpoint(flag, text)
    except BadOptions as error:
        raise argparse.ArgumentTypeError(str(error).removeprefix(f"{flag} ")) from None
    return text


def _prefix(text: str) -> str:
    try:
        return Keys(text).prefix
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def seconds(text: str, *, what: str = "time") -> float:
    """Return a number of seconds greater than 0; *what* it is for an error."""
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not (number > 0 and math.isfinite(number)):
        raise argparse.ArgumentTypeError(f"{text!r} is no {what}; a number of seconds greater than 0 is expected")
    return number
