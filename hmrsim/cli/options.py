"""The exit codes of commands with the errors behind them, and options that several commands have."""

from __future__ import annotations

import argparse
import math
import os
from collections.abc import Callable
from enum import IntEnum
from typing import Final

from hmrsim.diagnostics import shortened
from hmrsim.errors import (
    DocumentError,
    HmrsimError,
    OutputError,
    RecordingError,
    ResultsError,
    TraceError,
    printable,
)
from hmrsim.settings.arguments import reader
from hmrsim.settings.option import MAX_COUNT, MAX_SECONDS, Option
from hmrsim_zenoh.errors import (
    BadOptions,
    ConnectionDenied,
    PortTaken,
    PrefixTaken,
    RequestTimeout,
    SimulatorGone,
    SimulatorNotFound,
    Unreachable,
)


class ExitCode(IntEnum):
    """The exit codes of commands."""

    DONE = 0
    FAILED = 1
    WRONG_USE = 2
    NO_SIMULATOR = 3
    INTERRUPTED = 130


class WrongUse(HmrsimError):
    """The command line is invalid; the text says what was expected."""


class UnknownName(HmrsimError):
    """There is no robot, action, topic or place of this name; the text lists those that exist."""


class Refused(HmrsimError):
    """The simulator refused a request; the text says why."""


_WRONG_USE: Final = (
    WrongUse,
    DocumentError,
    ResultsError,
    TraceError,
    OutputError,
    RecordingError,
    BadOptions,
    PortTaken,
    PrefixTaken,
)
_NO_SIMULATOR: Final = (SimulatorNotFound, SimulatorGone, Unreachable, RequestTimeout)
_MAX_DIGITS: Final = 100
_WITH_PLACE: Final = (DocumentError, WrongUse)
"""Errors whose text begins with a file or a field."""


def code_of(error: HmrsimError) -> ExitCode:
    """Return the exit code of a command that ended with *error*."""
    if isinstance(error, ConnectionDenied):
        return ExitCode.FAILED
    if isinstance(error, _WRONG_USE):
        return ExitCode.WRONG_USE
    return ExitCode.NO_SIMULATOR if isinstance(error, _NO_SIMULATOR) else ExitCode.FAILED


def text_of(error: HmrsimError) -> str:
    """Return the message of *error* for the terminal, prefixed with ``hmrsim:`` unless it begins with a file or field.

    Control characters are escaped, since parts of the message may come from a file or another process.
    """
    prefix = "" if isinstance(error, _WITH_PLACE) else "hmrsim: "
    return "\n".join(f"{prefix}{printable(line)}" for line in str(error).rstrip("\n").split("\n"))


def add_json(parser: argparse.ArgumentParser, text: str = "print one JSON object") -> None:
    """Add ``--json``, with its help."""
    parser.add_argument("--json", action="store_true", help=text)


def add_connection_options(parser: argparse.ArgumentParser) -> None:
    """Add the session and log options that `connected` reads."""
    from hmrsim.program.log_options import add_log_options
    from hmrsim_zenoh.wire.options import add_session_options

    add_session_options(parser)
    add_log_options(parser)


def add_world_options(parser: argparse.ArgumentParser, *, metavar: str = "WORLD") -> None:
    """Add WORLD and all options that change it."""
    from hmrsim.settings.arguments import add_settings
    from hmrsim.settings.run import WorldSettings

    add_world_argument(parser, metavar=metavar)
    add_settings(parser, WorldSettings)


def add_world_argument(parser: argparse.ArgumentParser, *, metavar: str = "WORLD") -> None:
    """Add WORLD."""
    parser.add_argument("world", metavar=metavar, help="a world file of any format, or the name of a shipped world")


def add_ros_domain(parser: argparse.ArgumentParser, what: str) -> None:
    """Add ``--ros-domain-id``, with its help."""
    help_text = f"{what} (default: the environment's ROS_DOMAIN_ID, else 0)"
    parser.add_argument("--ros-domain-id", type=_ros_domain, metavar="N", help=help_text)


def _ros_domain(text: str) -> int:
    from hmrsim_zenoh.settings import domain_id

    try:
        return domain_id(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


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


def number_in(low: float, high: float, expected: str) -> Callable[[str], float]:
    """Return a reader of numbers greater than *low* and at most *high*; its error names what was *expected*."""

    def read(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not low < value <= high:
            raise argparse.ArgumentTypeError(f"{shortened(text)!r} is not {expected}")
        return value

    return read


def whole_in(low: int, high: int, expected: str) -> Callable[[str], int]:
    """Return a reader of whole numbers from *low* to *high*; its error names what was *expected*."""

    def read(text: str) -> int:
        if not text.isdecimal() or len(text) > _MAX_DIGITS or not low <= int(text) <= high:
            raise argparse.ArgumentTypeError(f"{shortened(text)!r} is not {expected}")
        return int(text)

    return read


positive: Final = reader(float, Option("", more_than=0, at_most=MAX_SECONDS))
"""Reads a finite number greater than 0, such as a duration in seconds."""

count: Final = whole_in(1, MAX_COUNT, f"a whole number greater than 0, up to {MAX_COUNT}")
"""Reads a whole number greater than 0."""

jobs: Final = whole_in(1, 10_000, "a number of processes")
"""Reads a number of processes."""
