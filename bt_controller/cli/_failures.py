"""The exit codes of errors."""

from __future__ import annotations

from bt_controller.cli._codes import FAILED, NO_SIMULATOR, WRONG_USE
from bt_controller.core.node import PortError
from bt_controller.coverage import CoverageError
from bt_controller.errors import TreeError
from hmrsim.errors import HmrsimError, OutputError
from hmrsim_zenoh.errors import (
    BadOptions,
    ConnectionDenied,
    NameTaken,
    PortTaken,
    RequestTimeout,
    SimulationEnded,
    SimulatorGone,
    SimulatorNotFound,
    Unreachable,
)


def exit_code(error: Exception) -> int | None:
    """Return the exit code of an error with a user-readable text; None for a bug."""
    if isinstance(error, (TreeError, PortError, CoverageError, BadOptions, OutputError, PortTaken, NameTaken)):
        return WRONG_USE
    if isinstance(error, (ConnectionDenied, SimulationEnded)):
        return FAILED
    if isinstance(error, (SimulatorNotFound, SimulatorGone, Unreachable, RequestTimeout)):
        return NO_SIMULATOR
    return FAILED if isinstance(error, HmrsimError) else None
