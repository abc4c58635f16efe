"""How a trial ends that nothing but its controller, its limits or its worker ends."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Final

from hmrsim.program.users_code import described, first_of
from hmrsim_zenoh.errors import Deadlock, SimulatorGone

if TYPE_CHECKING:
    from hmrsim.simulation.simulator import Simulator
    from hmrsim_zenoh.client.client import Client

Player = Callable[["Client", "Sequence[str]"], bool]
"""Controls the robots of a simulation to the end; returns whether that succeeded."""

SUCCEEDED: Final = "succeeded"
FAILED: Final = "failed"
"""The endings of a controller that ends by itself."""
CRASHED: Final = "crashed"
"""The ending of a run whose controller raised an error, or ended with an exit code other than 0 and 1."""
TIMEOUT: Final = "timeout"
"""The ending of a run that reached the limit of simulated time."""
HUNG: Final = "hung"
"""The ending of a run that waited or computed for too long, or whose time stood still."""
DEADLOCK: Final = "deadlock"
"""The ending of a run whose controller waits for what can't happen any more."""
MEMORY: Final = "out_of_memory"
"""The ending of a run that took too much memory."""
DIED: Final = "died"
"""The ending of a run whose worker has died, as of a segmentation fault."""
ERROR: Final = "error"
"""The ending of a run that could not be made, as its world or its controller can't be loaded."""
MISHAPS: Final = frozenset({CRASHED, HUNG, DEADLOCK, MEMORY, DIED, ERROR})
"""The endings that say more about a controller, or the machine, than about the mission."""
KILLED: Final = "killed"
"""The ending of a controller that was killed by a disturbance and stays away; of checks alone."""
BUILT_IN: Final = (SUCCEEDED, FAILED, TIMEOUT, *sorted(MISHAPS))
"""The endings that runs may have without being defined."""

_EXIT_FAILED: Final = 1
"""The exit code of a controller that has failed, and not crashed."""


class TimeLimit(BaseException):
    """A run takes too long; not an Exception, so that a controller does not catch it by accident.

    Args:
        why: Which of its times is over.
    """

    def __init__(self, why: str = "it takes too long") -> None:
        super().__init__(why)


def control(player: Player, client: Client, simulator: Simulator) -> tuple[str, str]:
    """Let a controller control the robots; return its ending, and the cause if it has not ended by itself."""
    try:
        return (SUCCEEDED if player(client, [*simulator.robots]) else FAILED), ""
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


def ending_of_code(code: int) -> tuple[str, str]:
    """Return the ending that a command's exit code stands for, and the cause of a crash."""
    if code == 0:
        return SUCCEEDED, ""
    if code == _EXIT_FAILED:
        return FAILED, ""
    return CRASHED, f"the controller ended with {f'signal {-code}' if code < 0 else f'exit code {code}'}"
