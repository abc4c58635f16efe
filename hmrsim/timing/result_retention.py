"""The retention of results for some wall seconds after the end of a goal."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Final

from hmrsim.engine.sim_time import wall_time
from hmrsim.protocol.commands import ForgetResult
from hmrsim.protocol.outputs import GoalChanged
from hmrsim.protocol.sinks import SelectiveSink

if TYPE_CHECKING:
    from hmrsim.simulation.simulator import Simulator

_PART: Final = 0.01
"""The largest part of their time by which results are kept longer."""
_MAX_LATENESS: Final = 1.0
"""The largest number of wall seconds by which results are kept longer."""


class Retention(SelectiveSink):
    """A sink that records when goals end by the wall clock, and drops their results when these have expired.

    Args:
        timeout: Wall seconds for which a result is kept; negative to keep it for ever.
        keep_results: The number of results that the simulator keeps per robot; older ones it drops by itself.
    """

    def __init__(self, timeout: float, keep_results: int = 1000) -> None:
        self._timeout = timeout
        self._keep_results = keep_results
        self._ended: dict[str, deque[tuple[float, str, str]]] = {}
        self._next = math.inf

    def handler_for(self, kind: type) -> Callable[[Any], object] | None:
        """Return the function that processes outputs of a type; None to ignore them."""
        return self._note_change if kind is GoalChanged and self._timeout >= 0 else None

    def _note_change(self, change: GoalChanged) -> None:
        if change.result is None:
            return
        expires = wall_time() + self._timeout
        if change.robot not in self._ended:
            self._ended[change.robot] = deque(maxlen=self._keep_results)
        self._ended[change.robot].append((expires, change.action, change.goal_id))
        self._next = min(self._next, expires)

    def apply(self, simulator: Simulator) -> None:
        """Submit the commands that drop expired results."""
        if self._next == math.inf or (now := wall_time()) < self._next:
            return
        for robot, ended in self._ended.items():
            while ended and ended[0][0] <= now:
                _, action, goal_id = ended.popleft()
                simulator.submit(ForgetResult(robot, action, goal_id))
        self._ended = {robot: ended for robot, ended in self._ended.items() if ended}
        earliest = min((ended[0][0] for ended in self._ended.values()), default=math.inf)
        # If goals end all the time, this loop does not run for each of them.
        self._next = max(earliest, now + min(self._timeout * _PART, _MAX_LATENESS))
