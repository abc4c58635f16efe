"""Faults of goals: some are rejected, others end ABORTED although the robot could execute them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING

from simpy import Timeout

from hmrsim.engine.sim_time import nanoseconds
from hmrsim.errors import GoalRejected
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS

if TYPE_CHECKING:
    from collections.abc import Iterable

    from hmrsim.engine.environment import Environment
    from hmrsim.goals.servers import ServedGoal
    from hmrsim.protocol.commands import SendGoal


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


class Hindrances:
    """The faults that goals meet.

    Args:
        active: Returns the active goals of a robot.
        abort: Ends an executing goal.
    """

    def __init__(
        self,
        env: Environment,
        active: Callable[[str], Iterable[ServedGoal]],
        abort: Callable[[ServedGoal, Abortion], None],
    ) -> None:
        self._env = env
        self._active = active
        self._abort = abort
        self._rejections: list[Rejection] = []
        self._abortions: list[Abortion] = []

    def reject(
        self, robot: str, action: str | None, *, reason: str, why: str, done: Callable[[], None]
    ) -> Callable[[], None]:
        """Reject goals, for a reason and a text; return what ends that."""
        rejection = Rejection(robot, action, reason, why, done)
        self._rejections.append(rejection)
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
        """Abort goals some seconds after they began to execute, also those that do so already; return what ends that.

        A goal that executes for longer already ends now.
        """
        abortion = Abortion(robot, action, code, why, cause, delay, done)
        self._abortions.append(abortion)
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
        """Return what ends a goal at the instant at which it begins; None for nothing."""
        for abortion in self._abortions:
            if abortion.delay == 0.0 and _hits(abortion, robot, action):
                return abortion
        return None

    def begun(self, goal: ServedGoal) -> None:
        """Abort a goal that begins to execute later, if a fault says so."""
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


def _drop(hindrances: list[Rejection] | list[Abortion], hindrance: Rejection | Abortion) -> None:
    """Forget one that may have been forgotten already."""
    if hindrance in hindrances:
        hindrances.remove(hindrance)  # type: ignore[arg-type]  # it is in it
