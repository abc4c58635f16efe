"""A trial: a run of a world with a controller for its robots, which may be disturbed."""

from __future__ import annotations

import threading
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Final, NamedTuple, Self

from hmrsim.program.users_code import described, first_of
from hmrsim_zenoh.errors import Deadlock, SimulatorGone

if TYPE_CHECKING:
    from hmrsim.simulation.simulator import Simulator
    from hmrsim.trials.disturbances import Disturbance, Disturber
    from hmrsim_zenoh.client.client import Client
    from hmrsim_zenoh.hosting.host import Host
    from hmrsim_zenoh.hosting.loopback_host import LoopbackHost

TOKEN_GONE: Final = "its liveliness token is gone"  # noqa: S105 - no password: why a participant is dropped
"""The reason for which the participant of a killed controller is dropped."""

Player = Callable[["Client", "Sequence[str]"], bool]
"""A controller: controls the robots to the end, and returns whether it succeeded."""

SUCCEEDED: Final = "succeeded"

FAILED: Final = "failed"
"""The endings of a controller that ends by itself."""

CRASHED: Final = "crashed"
"""The ending of a run whose controller raised an error, or ended with an exit code other than 0 and 1."""

TIMEOUT: Final = "timeout"
"""The ending of a run that reached the limit of simulated time."""

HUNG: Final = "hung"
"""The ending of a run that waited or computed for too long, or whose time did not advance."""

DEADLOCK: Final = "deadlock"
"""The ending of a run whose controller waits for something that can no longer happen."""

MEMORY: Final = "out_of_memory"
"""The ending of a run that took too much memory."""

OUT_OF_MEMORY: Final = "it takes more memory than its limit"
"""The cause of this ending."""

DIED: Final = "died"
"""The ending of a run whose worker died, for example by a segmentation fault."""

ERROR: Final = "error"
"""The ending of a run whose world or controller can't be loaded."""

MISHAPS: Final = frozenset({CRASHED, HUNG, DEADLOCK, MEMORY, DIED, ERROR})
"""The endings that are caused by the controller or the machine, and not by the mission."""

KILLED: Final = "killed"
"""The ending of a controller that a disturbance killed for good; only in checks."""

BUILT_IN: Final = (SUCCEEDED, FAILED, TIMEOUT, *sorted(MISHAPS))
"""The endings that runs can have without a definition in the file."""

_EXIT_FAILED: Final = 1
"""The exit code of a controller that failed without a crash."""


class TimeLimit(BaseException):
    """A run exceeds a time limit; not an Exception, so that a controller does not catch it by accident."""

    def __init__(self, why: str = "it takes too long") -> None:
        super().__init__(why)


def control(player: Player, client: Client, simulator: Simulator) -> tuple[str, str]:
    """Run a controller; return its ending, and the cause if it did not end by itself."""
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
            return MEMORY, OUT_OF_MEMORY
        case _:
            return CRASHED, described(error)


def ending_of_code(code: int) -> tuple[str, str]:
    """Return the ending for the exit code of a command, and the cause of a crash."""
    if code == 0:
        return SUCCEEDED, ""
    if code == _EXIT_FAILED:
        return FAILED, ""
    return CRASHED, f"the controller ended with {f'signal {-code}' if code < 0 else f'exit code {code}'}"


class Ended(NamedTuple):
    """The end of a controller.

    Attributes:
        ending: One of `hmrsim.trials.trial`.
        cause: Details that the ending lacks. May be empty.
        output: The last characters that a command printed.
    """

    ending: str
    cause: str
    output: str = ""


GONE: Final = KILLED, "it was killed, and is not started again"
"""The ending and the cause of a controller that a disturbance killed for good."""


class Trial(ABC):
    """The base class of trials: a controller, which may be restarted, and further ones beside it; a context manager.

    Subclasses call its constructor last, since a disturbance may come at once.

    Args:
        host: Serves the world in lockstep; *disturber* watches it.

    Attributes:
        simulator: The simulator; read it only while nothing runs.
    """

    def __init__(self, host: Host | LoopbackHost, disturber: Disturber | None) -> None:
        self.simulator: Simulator = host.simulator
        self._end = host.end
        self._lockstep = host.pacing.lockstep
        self._losses = host.losses
        # Set when the first controller has to be restarted.
        self._restarts = threading.Event()
        self._gone = False
        if disturber is not None:
            if any(each.disturbance == "reply_lost" for each in disturber.disturbances):
                self._losses.watch()
            disturber.attach(self._act)

    def __enter__(self) -> Self:
        """Return the trial."""
        return self

    def __exit__(self, *_error: object) -> None:
        """End all goals and clients."""
        self.close()

    @property
    @abstractmethod
    def over(self) -> bool:
        """True if the run ended, by its limit or by a sink, before the trial ended it."""

    @abstractmethod
    def play(self) -> Ended:
        """Run the controller to its end, once; afterwards the simulation is paused.

        If the controller was restarted, its last run counts. If it was killed for good, a second controller counts in
        its place. Otherwise a second controller is killed when the first one ends.

        Raises:
            HmrsimError: It can't be started.
        """

    def end(self, reason: str) -> None:
        """End the run after the current instant, from within the simulation, such as from a sink.

        The reason is the message in the results of the active goals, and in the messages to clients.
        """
        self._end(reason)

    @abstractmethod
    def close(self) -> None:
        """End all goals and clients."""

    def _act(self, disturbance: Disturbance) -> None:
        """Carry out a disturbance, in the simulation's thread at the end of an instant."""
        match disturbance.disturbance:
            case "controller_killed":
                self._kill(disturbance.restart_after)
            case "controller_stalled":
                for name in self._own_names:
                    self._lockstep.stall(name, self.simulator.now + (disturbance.duration or 0.0))
            case "second_controller":
                self._add()
            case "reply_lost":
                self._losses.lose_answers(disturbance.count or 1)
            case "request_repeated":
                self._losses.repeat_requests(disturbance.count or 1)

    @property
    @abstractmethod
    def _own_names(self) -> Sequence[str]:
        """The participant names of the first controller."""

    @abstractmethod
    def _kill(self, restart_after: float | None) -> None:
        """Kill the first controller, if it runs; restart it after *restart_after* simulated seconds, if given."""

    @abstractmethod
    def _add(self) -> None:
        """Start the controller a second time beside the first; simulated time waits until it joins."""
