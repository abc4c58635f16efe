"""The exit codes of commands, and the errors behind them."""

from __future__ import annotations

from collections.abc import Mapping
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
    """There is no robot, action or topic of this name; the text lists those that exist."""


class Refused(HmrsimError):
    """The simulator refused a request; the text says why."""


_CODES: Final[Mapping[type[HmrsimError], ExitCode]] = {
    WrongUse: ExitCode.WRONG_USE,
    WorldError: ExitCode.WRONG_USE,
    SettingsError: ExitCode.WRONG_USE,
    ExperimentError: ExitCode.WRONG_USE,
    CheckError: ExitCode.WRONG_USE,
    PropertyError: ExitCode.WRONG_USE,
    ResultsError: ExitCode.WRONG_USE,
    TraceError: ExitCode.WRONG_USE,
    OutputError: ExitCode.WRONG_USE,
    RecordingError: ExitCode.WRONG_USE,
    BadOptions: ExitCode.WRONG_USE,
    PortTaken: ExitCode.WRONG_USE,
    PrefixTaken: ExitCode.WRONG_USE,
    ConnectionDenied: ExitCode.FAILED,
    SimulatorNotFound: ExitCode.NO_SIMULATOR,
    SimulatorGone: ExitCode.NO_SIMULATOR,
    Unreachable: ExitCode.NO_SIMULATOR,
    RequestTimeout: ExitCode.NO_SIMULATOR,
}


def code_of(error: HmrsimError) -> ExitCode:
    """Return the exit code of a command that ended with *error*; 1 unless the table says otherwise."""
    return next((code for kind, code in _CODES.items() if isinstance(error, kind)), ExitCode.FAILED)


def text_of(error: HmrsimError) -> str:
    """Return the message of *error* for the terminal, prefixed with ``hmrsim:`` unless it begins with a file or field.

    Control characters are escaped, since parts of the message may come from a file or another process.
    """
    prefix = (
        ""
        if isinstance(error, (WorldError, SettingsError, ExperimentError, CheckError, PropertyError, WrongUse))
        else "hmrsim: "
    )
    return "\n".join(f"{prefix}{printable(line)}" for line in str(error).rstrip("\n").split("\n"))
