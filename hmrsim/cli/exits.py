"""The exit codes of commands, and the errors behind them."""

from __future__ import annotations

from enum import IntEnum
from typing import Final

from hmrsim.errors import (
    CheckError,
    ExperimentError,
    HmrsimError,
    OutputError,
    PropertyError,
    RecordingError,
    ResultsError,
    SettingsError,
    TraceError,
    WorldError,
    printable,
)
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
    WorldError,
    SettingsError,
    ExperimentError,
    CheckError,
    PropertyError,
    ResultsError,
    TraceError,
    OutputError,
    RecordingError,
    BadOptions,
    PortTaken,
    PrefixTaken,
)
_NO_SIMULATOR: Final = (SimulatorNotFound, SimulatorGone, Unreachable, RequestTimeout)
_WITH_PLACE: Final = (WorldError, SettingsError, ExperimentError, CheckError, PropertyError, WrongUse)
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
