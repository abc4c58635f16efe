"""The controllers of a run that are disturbed, whether they run in this process or are commands."""

from __future__ import annotations

import threading
from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from hmrsim.fault_search.disturbances import Disturbance, Disturber
    from hmrsim_zenoh.hosting.host import Host
    from hmrsim_zenoh.hosting.loopback_host import LoopbackHost

KILLED: Final = "killed"
"""The ending of a controller that was killed by a disturbance and stays away."""

GONE: Final = (KILLED, "it was killed, and is not started again")
"""That ending, and its cause."""


class Cast(ABC):
    """The base: the first controller, again if it is killed, and further ones beside it.

    A subclass calls its constructor last of all that a disturbance needs, as one may come at once.

    Args:
        host: Serves the world in lockstep; *disturber* watches it.
        disturber: What disturbs them.
    """

    def __init__(self, host: Host | LoopbackHost, disturber: Disturber) -> None:
        self._lockstep = host.pacing.lockstep
        self._losses = host.losses
        self._simulator = host.simulator
        # Set when the first controller is to be started again, and whether it was killed for good.
        self._restarts = threading.Event()
        self._gone = False
        if any(each.disturbance == "reply_lost" for each in disturber.disturbances):
            self._losses.watch()
        disturber.attach(self._act)

    def _act(self, disturbance: Disturbance) -> None:
        """Carry a disturbance out; in the simulation's thread, at the end of an instant."""
        match disturbance.disturbance:
            case "controller_killed":
                self._kill(disturbance.restart_after)
            case "controller_stalled":
                for name in self._own_names:
                    self._lockstep.stall(name, self._simulator.now + (disturbance.duration or 0.0))
            case "second_controller":
                self._add()
            case "reply_lost":
                self._losses.lose_answers(disturbance.count or 1)
            case "request_repeated":
                self._losses.repeat_requests(disturbance.count or 1)

    @property
    @abstractmethod
    def _own_names(self) -> Sequence[str]:
        """The participants of the first controller."""

    @abstractmethod
    def _kill(self, restart_after: float | None) -> None:
        """Kill the first controller, if it runs; it is to be started again after so many seconds, or never."""

    @abstractmethod
    def _add(self) -> None:
        """Start the controller once more beside the first, and have time wait for it to join."""
