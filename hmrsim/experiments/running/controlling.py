"""One controller that runs within this process, and how it ends."""

from __future__ import annotations

import traceback
from typing import TYPE_CHECKING

from hmrsim.errors import HmrsimError
from hmrsim.experiments.results.row import CRASHED, HUNG, MEMORY
from hmrsim_zenoh.errors import SimulatorGone

if TYPE_CHECKING:
    from hmrsim.experiments.running.controllers import Controller
    from hmrsim.simulation.simulator import Simulator
    from hmrsim_zenoh.client.client import Client

SUCCEEDED, FAILED = "succeeded", "failed"
"""The endings of a controller that ends by itself."""


class WallLimit(BaseException):
    """A run takes too long; not an Exception, so that a controller does not catch it by accident."""


def control(controller: Controller, client: Client, simulator: Simulator) -> tuple[str, str]:
    """Let a controller control the robots; return its ending, and the cause if it has not ended by itself."""
    try:
        return (SUCCEEDED if controller(client, [*simulator.robots]) else FAILED), ""
    except SimulatorGone:
        return FAILED, ""
    except WallLimit as limit:
        return HUNG, str(limit)
    except MemoryError:
        return MEMORY, "it takes more memory than its limit"
    except HmrsimError as error:
        return CRASHED, f"{type(error).__name__}: {error}"
    except (Exception, SystemExit) as error:  # noqa: BLE001 - whatever the user's code raises
        return CRASHED, described(error)


def described(error: BaseException) -> str:
    """Return an error of the user's code as one line: the error and its place."""
    text = f"{type(error).__name__}: {error}".splitlines()[0]
    frames = traceback.extract_tb(error.__traceback__)
    return f"{text} ({frames[-1].filename}:{frames[-1].lineno})" if frames else text
