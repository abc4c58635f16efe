"""BehaviorTree.CPP's decorators that tick a child again: Repeat, RetryUntilSuccessful, KeepRunningUntilFailure."""

from __future__ import annotations

from typing import ClassVar, Final

from py_trees.common import Status

from bt_controller.core.node import EACH_PERIOD, Decoration, Ticks
from bt_controller.core.ports import INT, input_port
from bt_controller.core.sim_time import now
from bt_controller.nodes import Family
from bt_controller.nodes.turns import MAX_TURNS

_FOREVER: Final = -1


class _Again(Decoration):
    """A decorator that may be RUNNING while its child is not.

    A child that was RUNNING and ended at the same instant starts again only after time has advanced: its goals ended at
    once, and would do so again and again at this instant.
    """

    _began = 0.0
    _instant = False

    def initialise(self) -> None:
        """Start over."""
        self._instant = False

    @property
    def rests(self) -> bool:
        """Whether the child must not start again before time has advanced."""
        return self._instant and now() == self._began

    def take_turn(self) -> Ticks:
        """Tick the child, and return its status; INVALID if it was skipped."""
        ran = self.child.status is Status.RUNNING
        if not ran:
            self._began = now()
        status = yield from self.tick_child()
        self._instant = ran and status is not Status.RUNNING
        return status

    def next_tick_time(self) -> float:
        """Return that the node needs polling if the child is not RUNNING, as it starts again."""
        return super().next_tick_time() if self.child.status is Status.RUNNING else EACH_PERIOD


class _Counted(_Again):
    """Ticks its child again after one status, as often as a port says; ends with any other status.

    The next repetition follows at once; an endless one of a child that takes no time, at the next tick.
    """

    port: ClassVar[str]
    again: ClassVar[Status]

    def initialise(self) -> None:
        """Begin to count."""
        super().initialise()
        self._count = 0

    def advance(self) -> Ticks:
        """Tick the child until it is RUNNING or the repetitions are over."""
        for _ in range(MAX_TURNS):
            limit = self.read(self.port)
            if self._count >= limit != _FOREVER:
                return self.again
            if self.rests:
                break
            ran = self.child.status is Status.RUNNING
            status = yield from self.take_turn()
            if status is not self.again:
                return status
            self._count += 1
            if limit == _FOREVER and not ran:
                break
        return Status.RUNNING


class Repeat(_Counted):
    """Ticks its child until it has succeeded *num_cycles* times; fails when the child does.

    Repetitions follow each other at once. After one that took no time the next follows a period later if the child was
    RUNNING, and at the next tick if the number is unlimited (-1) or after a thousand. If the child is skipped, so is
    the node.
    """

    INPUTS: ClassVar = {"num_cycles": input_port(INT, "Number of successes; -1 for unlimited")}
    port = "num_cycles"
    again = Status.SUCCESS


class RetryUntilSuccessful(_Counted):
    """Ticks its child until it succeeds; fails when the child has failed *num_attempts* times.

    Repetitions follow each other at once. After one that took no time the next follows a period later if the child was
    RUNNING, and at the next tick if the number is unlimited (-1) or after a thousand. If the child is skipped, so is
    the node.
    """

    INPUTS: ClassVar = {"num_attempts": input_port(INT, "Number of attempts; -1 for unlimited")}
    port = "num_attempts"
    again = Status.FAILURE


class KeepRunningUntilFailure(_Again):
    """Runs until its child fails, and then fails; a child that has ended otherwise starts again at the next tick."""

    def advance(self) -> Ticks:
        """Tick the child."""
        if self.rests:
            return Status.RUNNING
        status = yield from self.take_turn()
        return Status.FAILURE if status is Status.FAILURE else Status.RUNNING


FAMILY = Family.of("repetition", Repeat, RetryUntilSuccessful, KeepRunningUntilFailure)
