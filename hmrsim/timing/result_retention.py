"""Retention of results, in wall seconds from a goal's end."""

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
_MAX_LATENESS: Final = 1.0
"""By how much of their time results are kept longer, at most, and by how many wall seconds."""


class Retention(SelectiveSink):
    """A sink that records when goals ended by the wall clock, so that their results are dropped in time.

    Args:
        timeout: Wall seconds that a result is kept; negative for ever.
        keep_results: Results that are kept per robot anyway: of more goals none needs to be dropped.
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
        # Where goals end all the time, the robots are not looked through for each of them.
        self._next = max(earliest, now + min(self._timeout * _PART, _MAX_LATENESS))
