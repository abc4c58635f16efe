"""Retention of results, in wall seconds from a goal's end."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING

from hmrsim.engine.wall_clock import wall_time
from hmrsim.protocol.commands import ForgetResult
from hmrsim.protocol.outputs import GoalChanged

if TYPE_CHECKING:
    from hmrsim.protocol.outputs import Output
    from hmrsim.protocol.topics import Topic
    from hmrsim.simulation.simulator import Simulator


class Retention:
    """A sink that remembers when goals ended by the wall clock, so that their results are dropped in time.

    Args:
        timeout: Wall seconds that a result is kept; negative for ever.
    """

    def __init__(self, timeout: float) -> None:
        self._timeout = timeout
        self._ended: deque[tuple[float, ForgetResult]] = deque()

    def emit(self, output: Output) -> None:
        """Record a goal that has ended."""
        if self._timeout >= 0 and isinstance(output, GoalChanged) and output.status.terminal:
            forget = ForgetResult(output.robot, output.action, output.goal_id)
            self._ended.append((wall_time() + self._timeout, forget))

    def wants(self, _topic: Topic) -> bool:
        """Return False: ends of goals are delivered without it."""
        return False

    def apply(self, simulator: Simulator) -> None:
        """Submit the commands that drop expired results."""
        while self._ended and self._ended[0][0] <= wall_time():
            simulator.submit(self._ended.popleft()[1])
