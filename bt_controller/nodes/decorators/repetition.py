"""BehaviorTree.CPP's decorators that tick a child again: Repeat, RetryUntilSuccessful, KeepRunningUntilFailure."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, Final

from py_trees.common import Status

from bt_controller.node import EACH_PERIOD, Decoration
from bt_controller.nodes import Family
from bt_controller.ports import INT, wants

if TYPE_CHECKING:
    from collections.abc import Generator

    from py_trees.behaviour import Behaviour

_FOR_EVER: Final = -1
_MOST: Final = 1000
"""Turns in one tick: a large number and a child that takes no time must not hold up everybody else."""


class _Again(Decoration):
    """A decorator that may run while its child does not."""

    def next_look(self) -> float:
        """Return that the child is to begin again if it does not run."""
        return super().next_look() if self.child.status is Status.RUNNING else EACH_PERIOD


class _Counted(_Again):
    """Ticks its child again after one outcome, as often as a port says; ends with any other outcome.

    Where there is no end to it, and the child takes no time, the next turn comes with the next tick; otherwise at once.
    """

    port: ClassVar[str]
    again: ClassVar[Status]

    def initialise(self) -> None:
        """Begin to count."""
        self._count = 0

    def advance(self) -> Generator[Behaviour, None, Status]:
        """Tick the child until it runs or its turns are over."""
        for _ in range(_MOST):
            most = self.read(self.port)
            if self._count >= most != _FOR_EVER:
                return self.again
            took_time = self.child.status is Status.RUNNING
            status = yield from self.tick_child()
            if status is not self.again:
                return status
            self._count += 1
            if most == _FOR_EVER and not took_time:
                break
        return Status.RUNNING


class Repeat(_Counted):
    """Ticks its child as often as it is told, as long as that succeeds; succeeds then, and fails when the child does.

    Turns follow each other at once. Without an end (-1), and with a child that takes no time, the next comes with the
    next tick; so it does after a thousand turns. Where the child is skipped, so is the node.
    """

    INPUTS: ClassVar = {"num_cycles": wants(INT, "How often the child has to succeed; -1 for ever")}
    port = "num_cycles"
    again = Status.SUCCESS


class RetryUntilSuccessful(_Counted):
    """Ticks its child as often as it is told, as long as that fails; fails then, and succeeds when the child does.

    Turns follow each other at once. Without an end (-1), and with a child that takes no time, the next comes with the
    next tick; so it does after a thousand turns. Where the child is skipped, so is the node.
    """

    INPUTS: ClassVar = {"num_attempts": wants(INT, "How often the child may fail; -1 for ever")}
    port = "num_attempts"
    again = Status.FAILURE


class KeepRunningUntilFailure(_Again):
    """Runs until its child fails, and fails then; a child that has ended otherwise begins again with the next tick."""

    def advance(self) -> Generator[Behaviour, None, Status]:
        """Tick the child."""
        status = yield from self.tick_child()
        return Status.FAILURE if status is Status.FAILURE else Status.RUNNING


FAMILY = Family(
    "repetition",
    {node.__name__: node for node in (Repeat, RetryUntilSuccessful, KeepRunningUntilFailure)},
)
