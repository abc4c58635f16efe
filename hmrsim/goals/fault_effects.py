"""The effects of faults on goals: rejections, aborts, delayed updates and lost connections."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING

from simpy import Event, Timeout

from hmrsim.engine.sim_time import nanoseconds
from hmrsim.errors import GoalRejected
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.protocol.outputs import StatusChanged

if TYPE_CHECKING:
    from collections.abc import Iterable

    from hmrsim.engine.environment import Environment
    from hmrsim.goals.servers import ServedGoal
    from hmrsim.protocol.commands import CancelGoal, ChangeState, GetResult, SendGoal


@dataclass(frozen=True, eq=False)
class Rejection:
    """Goals of a robot, of one action or of all, are rejected; *done* is called with each."""

    robot: str
    action: str | None
    reason: str
    why: str
    done: Callable[[], None]


@dataclass(frozen=True, eq=False)
class Abortion:
    """Goals of a robot, of one action or of all, end ABORTED some seconds after they began; *done* is called with each.

    Attributes:
        code: The error code of the result; None for the action's own for errors without one.
        cause: Why, as an identifier.
        timers: The timeouts that abort executing goals.
    """

    robot: str
    action: str | None
    code: int | None
    why: str
    cause: str
    delay: float
    done: Callable[[], None]
    timers: dict[ServedGoal, Timeout] = field(default_factory=dict)


class GoalFaults:
    """The faults that goals meet.

    Args:
        active: Returns the active goals of a robot.
        abort: Ends an executing goal.

    Attributes:
        armed: Whether there has been any such fault; most runs have none.
    """

    def __init__(
        self,
        env: Environment,
        active: Callable[[str], Iterable[ServedGoal]],
        abort: Callable[[ServedGoal, Abortion], None],
    ) -> None:
        self.armed = False
        self._env = env
        self._active = active
        self._abort = abort
        self._rejections: list[Rejection] = []
        self._abortions: list[Abortion] = []

    def reject(
        self, robot: str, action: str | None, *, reason: str, why: str, done: Callable[[], None]
    ) -> Callable[[], None]:
        """Reject goals for a reason and with a text; return the function that ends this."""
        rejection = Rejection(robot, action, reason, why, done)
        self._rejections.append(rejection)
        self.armed = True
        return lambda: _drop(self._rejections, rejection)

    def abort(
        self,
        robot: str,
        action: str | None,
        *,
        code: int | None,
        why: str,
        cause: str,
        delay: float,
        done: Callable[[], None],
    ) -> Callable[[], None]:
        """Abort goals when they have executed for some seconds; return the function that ends this.

        A goal that executes for longer already ends now.
        """
        abortion = Abortion(robot, action, code, why, cause, delay, done)
        self._abortions.append(abortion)
        self.armed = True
        for goal in [*self._active(robot)]:
            if _hits(abortion, goal.server.robot.name, goal.server.action.name):
                self._set_timer(abortion, goal)
        return partial(self._stop, abortion)

    def check(self, command: SendGoal) -> None:
        """Check that no fault lets a goal be rejected.

        Raises:
            GoalRejected: One does.
        """
        for rejection in self._rejections:
            if _hits(rejection, command.robot, command.action):
                rejection.done()
                raise GoalRejected(rejection.reason, rejection.why)

    def met(self, robot: str, action: str) -> Abortion | None:
        """Return the abortion that ends a goal at the instant at which it begins; None if there is none."""
        for abortion in self._abortions:
            if abortion.delay == 0.0 and _hits(abortion, robot, action):
                return abortion
        return None

    def begun(self, goal: ServedGoal) -> None:
        """Schedule the abortion of a goal that begins to execute, if a fault requires it."""
        for abortion in self._abortions:
            if _hits(abortion, goal.server.robot.name, goal.server.action.name):
                self._set_timer(abortion, goal)

    def ended(self, goal: ServedGoal) -> None:
        """Drop the timers of a goal that has ended."""
        for abortion in self._abortions:
            timer = abortion.timers.pop(goal, None)
            if timer is not None:
                self._env.abandon(timer)

    def _set_timer(self, abortion: Abortion, goal: ServedGoal) -> None:
        # The stamp of the start is 1, as 0 means "unset".
        since = (nanoseconds(self._env.now) - goal.stamp) / NANOSECONDS if goal.stamp > 1 else self._env.now
        left = max(0.0, abortion.delay - since)
        timer = abortion.timers[goal] = Timeout(self._env, left)
        timer.callbacks = [lambda _event: self._due(abortion, goal)]

    def _due(self, abortion: Abortion, goal: ServedGoal) -> None:
        del abortion.timers[goal]
        self._abort(goal, abortion)
        abortion.done()

    def _stop(self, abortion: Abortion) -> None:
        _drop(self._abortions, abortion)
        for timer in abortion.timers.values():
            self._env.abandon(timer)
        abortion.timers.clear()


def _hits(hindrance: Rejection | Abortion, robot: str, action: str) -> bool:
    return hindrance.robot == robot and hindrance.action in (None, action)


def _drop(faults: list[Rejection] | list[Abortion], hindrance: Rejection | Abortion) -> None:
    """Remove a rejection or abortion, if it is still in the list."""
    if hindrance in faults:
        faults.remove(hindrance)  # type: ignore[arg-type]  # it is in it


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


class DelayedUpdates:
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


class DisconnectedRobots(set[str]):
    """The unreachable robots: requests are rejected, and results are withheld. Their scripts continue."""

    def reach(self, command: SendGoal | CancelGoal | GetResult | ChangeState) -> bool:
        """Return whether a request reaches its robot; requests of the robot's own script always do."""
        return command.robot not in self or isinstance(command.reply_to, Event)

    def check(self, command: SendGoal) -> None:
        """Check that a goal reaches its robot.

        Raises:
            GoalRejected: It does not.
        """
        if not self.reach(command):
            raise GoalRejected("not_ready", no_connection(command.robot))


def no_connection(robot: str) -> str:
    """Return why a robot can't be reached."""
    return f"no connection to {robot}; it is lost for a while"
