"""One controller that runs within this process, and how it ends."""

from __future__ import annotations

import os
import sysconfig
import traceback
from pathlib import Path
from typing import TYPE_CHECKING, Final

import hmrsim
from hmrsim.errors import HmrsimError
from hmrsim.experiments.judging.labels import CRASHED, HUNG, MEMORY
from hmrsim_zenoh.errors import SimulatorGone

if TYPE_CHECKING:
    from hmrsim.experiments.running.controllers import Controller
    from hmrsim.simulation.simulator import Simulator
    from hmrsim_zenoh.client.client import Client

_OURS: Final = Path(hmrsim.__file__).parent
_NOT_THEIRS: Final = tuple(
    f"{folder}{os.sep}"
    for folder in (
        *(sysconfig.get_path(name) for name in ("stdlib", "platstdlib", "purelib", "platlib")),
        _OURS,
        _OURS.with_name("hmrsim_zenoh"),
    )
)
"""The folders of Python, of installed packages, and of the simulator: the place of an error is sought elsewhere."""

SUCCEEDED, FAILED = "succeeded", "failed"
"""The endings of a controller that ends by itself."""


class WallLimit(BaseException):
    """A run takes too long; not an Exception, so that a controller does not catch it by accident."""


def control(controller: Controller, client: Client, simulator: Simulator) -> tuple[str, str]:
    """Let a controller control the robots; return its ending, and the cause if it has not ended by itself."""
    try:
        return (SUCCEEDED if controller(client, [*simulator.robots]) else FAILED), ""
    except (WallLimit, Exception, SystemExit, BaseExceptionGroup) as error:  # noqa: BLE001 - whatever users' code raises
        return _ending(_first(error))


def _first(error: BaseException) -> BaseException:
    """Return the first error of a group, which is what tasks of asyncio raise."""
    while isinstance(error, BaseExceptionGroup):
        error = error.exceptions[0]
    return error


def _ending(error: BaseException) -> tuple[str, str]:
    match error:
        case SimulatorGone():
            return FAILED, ""
        case WallLimit():
            return HUNG, str(error)
        case MemoryError():
            return MEMORY, "it takes more memory than its limit"
        case HmrsimError():
            return CRASHED, f"{type(error).__name__}: {error}"
        case _:
            return CRASHED, described(error)


def described(error: BaseException) -> str:
    """Return an error of the user's code as one line: the error and its place, in that code if it was there."""
    error = _first(error)
    text = f"{type(error).__name__}: {error}".splitlines()[0]
    frames = traceback.extract_tb(error.__traceback__)
    theirs = [frame for frame in frames if not frame.filename.startswith(_NOT_THEIRS)] or frames
    return f"{text} ({theirs[-1].filename}:{theirs[-1].lineno})" if theirs else text
