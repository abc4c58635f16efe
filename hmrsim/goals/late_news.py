"""Delayed updates about goals: changes of status and results that reach clients late."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING

from simpy import Timeout

from hmrsim.protocol.outputs import StatusChanged

if TYPE_CHECKING:
    from collections.abc import Iterable

    from hmrsim.engine.environment import Environment
    from hmrsim.goals.servers import ServedGoal


@dataclass
class _Line:
    """The updates under way from one robot, in order.

    Attributes:
        delays: Delays in seconds, which add up.
        known: The statuses that clients know, by action.
    """

    known: dict[str, StatusChanged]
    delays: list[float] = field(default_factory=list)
    under_way: deque[tuple[Timeout, Callable[[], None]]] = field(default_factory=deque)


class LateNews:
    """The updates about goals that have not reached clients yet.

    Args:
        statuses: Returns the statuses of all stored goals of a robot.

    Attributes:
        late: The robots whose updates are delayed, with those under way.
    """

    def __init__(self, env: Environment, statuses: Callable[[str], Iterable[StatusChanged]]) -> None:
        self._env = env
        self._statuses = statuses
        self.late: dict[str, _Line] = {}
        self._held: set[ServedGoal] = set()

    def delay(self, robot: str, seconds: float) -> Callable[[], None]:
        """Delay the updates of a robot; return a function that ends the delay and delivers the pending ones."""
        if robot not in self.late:
            self.late[robot] = _Line({status.action: status for status in self._statuses(robot)})
        self.late[robot].delays.append(seconds)
        return partial(self._end, robot, seconds)

    def known(self, robot: str, action: str) -> StatusChanged | None:
        """Return the statuses of an action's goals as clients know them; None if they are up to date."""
        line = self.late.get(robot)
        return None if line is None else line.known.get(action, StatusChanged(robot, action, ()))

    def send(self, status: StatusChanged, tell: Callable[[], None]) -> None:
        """Publish the statuses of an action's goals later, by calling *tell*."""

        def arrive() -> None:
            line = self.late.get(status.robot)
            if line is not None:
                line.known[status.action] = status
            tell()

        self._send(status.robot, arrive)

    def hold(self, goal: ServedGoal, tell: Callable[[], None]) -> None:
        """Hold back the result of a goal; *tell* is called when it arrives."""

        def arrive() -> None:
            self._held.discard(goal)
            tell()

        self._held.add(goal)
        self._send(goal.server.robot.name, arrive)

    def holds(self, goal: ServedGoal) -> bool:
        """Return whether the result of a goal is under way."""
        return goal in self._held

    def flush(self, robot: str | None = None) -> None:
        """Deliver the pending updates of a robot, or of all, now."""
        for name in [*self.late] if robot is None else [robot]:
            if name in self.late:
                self._arrive(self.late[name])

    def _send(self, robot: str, arrive: Callable[[], None]) -> None:
        line = self.late[robot]
        timer = Timeout(self._env, math.fsum(line.delays))
        line.under_way.append((timer, arrive))

        def due(_event: object) -> None:
            # Delays become no shorter while something is under way.
            line.under_way.popleft()
            arrive()

        timer.callbacks = [due]

    def _arrive(self, line: _Line) -> None:
        under_way, line.under_way = line.under_way, deque()
        for timer, arrive in under_way:
            self._env.abandon(timer)
            arrive()

    def _end(self, robot: str, seconds: float) -> None:
        line = self.late[robot]
        line.delays.remove(seconds)
        if not line.delays:
            del self.late[robot]
        self._arrive(line)
