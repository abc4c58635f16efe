"""One controller that runs within this process, and how it ends."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.experiments.judging.labels import CRASHED, DEADLOCK, HUNG, MEMORY
from hmrsim.program.users_code import described, first_of
from hmrsim_zenoh.errors import Deadlock, SimulatorGone

if TYPE_CHECKING:
    from hmrsim.experiments.running.controllers import Controller
    from hmrsim.simulation.simulator import Simulator
    from hmrsim_zenoh.client.client import Client

SUCCEEDED, FAILED = "succeeded", "failed"
"""The endings of a controller that ends by itself."""


class TimeLimit(BaseException):
    """A run takes too long; not an Exception, so that a controller does not catch it by accident.

    Args:
        why: Which of its times is over.
    """

    def __init__(self, why: str = "it takes too long") -> None:
        super().__init__(why)


def control(controller: Controller, client: Client, simulator: Simulator) -> tuple[str, str]:
    """Let a controller control the robots; return its ending, and the cause if it has not ended by itself."""
    try:
        return (SUCCEEDED if controller(client, [*simulator.robots]) else FAILED), ""
    except (TimeLimit, Exception, SystemExit, BaseExceptionGroup) as error:  # noqa: BLE001 - whatever users' code raises
        return _ending(first_of(error))


def _ending(error: BaseException) -> tuple[str, str]:
    match error:
        case SimulatorGone():
            return FAILED, "; ".join(getattr(error, "__notes__", ()))
        case TimeLimit():
            return HUNG, str(error)
        case Deadlock():
            return DEADLOCK, str(error)
        case MemoryError():
            return MEMORY, "it takes more memory than its limit"
        case _:
            return CRASHED, described(error)
