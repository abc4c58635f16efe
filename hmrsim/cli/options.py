"""Options that several commands have, and the types of their values."""

from __future__ import annotations

import argparse
import math
import os

from hmrsim.settings import option
from hmrsim.settings.option import MAX_SECONDS, shortened
from hmrsim_zenoh.errors import BadOptions


def add_json(parser: argparse.ArgumentParser, text: str = "print one JSON object") -> None:
    """Add ``--json``, with its help."""
    parser.add_argument("--json", action="store_true", help=text)


def add_connection_options(parser: argparse.ArgumentParser) -> None:
    """Add the session and log options that `connected` reads."""
    from hmrsim.program.log_options import add_log_options
    from hmrsim_zenoh.wire.options import add_session_options

    add_session_options(parser)
    add_log_options(parser)


def add_world_options(parser: argparse.ArgumentParser, *, argument: str = "world") -> None:
    """Add WORLD and all options that change it."""
    from hmrsim.settings.arguments import add_settings
    from hmrsim.settings.run import WorldSettings

    add_world_argument(parser, argument=argument)
    add_settings(parser, WorldSettings)


def add_world_argument(parser: argparse.ArgumentParser, *, argument: str = "world") -> None:
    """Add WORLD."""
    parser.add_argument(
        argument, metavar=argument.upper(), help="a world file of any format, or the name of a shipped world"
    )


def ros_domain_of_environment() -> int:
    """Return the ROS domain of the environment; 0 if it is not set.

    Raises:
        BadOptions: It is not a domain id.
    """
    from hmrsim_zenoh.settings import ROS_DOMAIN_ID, domain_id

    try:
        return domain_id(os.environ.get(ROS_DOMAIN_ID) or "0")
    except ValueError as error:
        raise BadOptions(f"{ROS_DOMAIN_ID}: {error}; correct it, or give --ros-domain-id") from None


def positive(text: str) -> float:
    """Return a finite number greater than 0, such as a duration in seconds."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{shortened(text)!r} is not a finite number")
    if value <= 0:
        raise argparse.ArgumentTypeError(f"{text} is not greater than 0")
    if value > MAX_SECONDS:
        raise argparse.ArgumentTypeError(f"{shortened(text)} is greater than {MAX_SECONDS:g}")
    return value


def count(text: str) -> int:
    """Return a whole number greater than 0."""
    try:
        return option.count(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def jobs(text: str) -> int:
    """Return a number of processes."""
    if not text.isdecimal() or not 0 < int(text) <= 10_000:  # noqa: PLR2004
        raise argparse.ArgumentTypeError(f"{text!r} is not a number of processes")
    return int(text)


def number_in(text: str, low: float, high: float, *, otherwise: str) -> float:
    """Return a number greater than *low* and at most *high*.

    Raises:
        ArgumentTypeError: It is not such a number; the text is *otherwise*.
    """
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not low < value <= high:
        raise argparse.ArgumentTypeError(f"{text!r} is not {otherwise}")
    return value
