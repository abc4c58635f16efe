"""BehaviorTree.CPP's decorators that tick a child again: Repeat, RetryUntilSuccessful, KeepRunningUntilFailure."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, Final

from py_trees.common import Status

from bt_controller.core.node import EACH_PERIOD, Decoration
from bt_controller.core.ports import INT, input_port
from bt_controller.core.sim_time import now
from bt_controller.nodes import Family
from bt_controller.nodes.turns import MAX_TURNS

if TYPE_CHECKING:
    from collections.abc import Generator

    from py_trees.behaviour import Behaviour

_FOR_EVER: Final = -1


class _Again(Decoration):
    """A decorator that may run while its child does not.

    A child that ran, and for which no time has gone by, begins again when some has: its goals ended at once, and would
    do so again and again at this very instant.
    """

    _began = 0.0
    _instant = False

    def initialise(self) -> None:
        """Begin anew."""
        self._instant = False

    @property
    def rests(self) -> bool:
        """Whether the child is not to begin again before time has gone by."""
        return self._instant and now() == self._began

    def take_turn(self) -> Generator[Behaviour, None, Status]:
        """Tick the child, and return its status; INVALID if it was skipped."""
        ran = self.child.status is Status.RUNNING
        if not ran:
            self._began = now()
        status = yield from self.tick_child()
        self._instant = ran and status is not Status.RUNNING
        return status

    def next_tick_time(self) -> float:
        """Return that the child is to begin again if it does not run."""
        return super().next_tick_time() if self.child.status is Status.RUNNING else EACH_PERIOD


class _Counted(_Again):
    """Ticks its child again after one outcome, as often as a port says; ends with any other outcome.

    The next turn comes at once; where there is no end to it, and the child takes no time, with the next tick.
    """

    port: ClassVar[str]
    again: ClassVar[Status]

    def initialise(self) -> None:
        """Begin to count."""
        super().initialise()
        self._count = 0

    def advance(self) -> Generator[Behaviour, None, Status]:
        """Tick the child until it runs or its turns are over."""
        for _ in range(MAX_TURNS):
            most = self.read(self.port)
            if self._count >= most != _FOR_EVER:
                return self.again
            if self.rests:
                break
            ran = self.child.status is Status.RUNNING
            status = yield from self.take_turn()
            if status is not self.again:
                return status
            self._count += 1
            if most == _FOR_EVER and not ran:
                break
        return Status.RUNNING


class Repeat(_Counted):
    """Ticks its child *num_cycles* times, as long as that succeeds; succeeds then, and fails when the child does.

    Turns follow each other at once. After one that took no time the next comes a period later if the child ran, and
    with the next tick if there is no end to it (-1), or after a thousand. Where the child is skipped, so is the node.
    """

    INPUTS: ClassVar = {"num_cycles": input_port(INT, "How often the child has to succeed; -1 for ever")}
    port = "num_cycles"
    again = Status.SUCCESS


class RetryUntilSuccessful(_Counted):
    """Ticks its child *num_attempts* times, as long as that fails; fails then, and succeeds when the child does.

    Turns follow each other at once. After one that took no time the next comes a period later if the child ran, and
    with the next tick if there is no end to it (-1), or after a thousand. Where the child is skipped, so is the node.
    """

    INPUTS: ClassVar = {"num_attempts": input_port(INT, "How often the child may fail; -1 for ever")}
    port = "num_attempts"
    again = Status.FAILURE


class KeepRunningUntilFailure(_Again):
    """Runs until its child fails, and fails then; a child that has ended otherwise begins again with the next tick."""

    def advance(self) -> Generator[Behaviour, None, Status]:
        """Tick the child."""
        if self.rests:
            return Status.RUNNING
        status = yield from self.take_turn()
        return Status.FAILURE if status is Status.FAILURE else Status.RUNNING


FAMILY = Family(
    "repetition",
    {node.__name__: node for node in (Repeat, RetryUntilSuccessful, KeepRunningUntilFailure)},
)
