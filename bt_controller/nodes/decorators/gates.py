"""Decorators that decide whether and when a child starts, or change its result."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import ClassVar, Final

from py_trees.common import Status

from bt_controller.core.node import EACH_PERIOD, Decoration, Ticks
from bt_controller.core.ports import ANY, BOOL, STATUS, UNSIGNED, input_port
from bt_controller.core.sim_time import now, reached
from bt_controller.nodes import Family
from bt_controller.nodes.poses import Watching
from bt_controller.scripting.scripted import Scripted


class SkipUnlessUpdated(Watching, Decoration):
    """Ticks its child if an entry was written since the last check, and returns the child's status.

    Otherwise it is skipped. The entry is not checked while the child is RUNNING; a halt does not count as a check.
    """

    INPUTS: ClassVar = {"entry": input_port(ANY, "Key of the entry, with or without braces")}
    otherwise: ClassVar = Status.INVALID

    def next_tick_time(self) -> float:
        """Return that the entry has to be polled."""
        return super().next_tick_time() if self.child.status is Status.RUNNING else EACH_PERIOD

    def advance(self) -> Ticks:
        """Check the entry, or tick the RUNNING child."""
        if self.child.status is not Status.RUNNING and not self.updated():
            return self.otherwise
        return (yield from self.tick_child())


class WaitValueUpdate(SkipUnlessUpdated):
    """Ticks its child if an entry was written since the last check, and returns the child's status.

    Otherwise it is RUNNING. The entry is not checked while the child is RUNNING; a halt does not count as a check.
    """

    otherwise = Status.RUNNING


class RunOnce(Decoration):
    """Ticks its child until it has ended once, and returns its status; after that the child is never ticked again.

    With *then_skip*, the default, the node is then skipped; otherwise it returns the child's last status. A child that
    is halted or skipped has not ended.
    """

    INPUTS: ClassVar = {"then_skip": input_port(BOOL, "Whether the node is skipped afterwards", default=True)}

    _outcome: Status | None = None

    def advance(self) -> Ticks:
        """Tick the child unless it has ended before."""
        if self._outcome is not None:
            return Status.INVALID if self.read("then_skip") else self._outcome
        status = yield from self.tick_child()
        if status in (Status.SUCCESS, Status.FAILURE):
            self._outcome = status
        return status


class SingleTrigger(Decoration):
    """Ticks its child until it has ended, and returns its status; after that it fails until it is reset.

    With ``is_global`` a reset has no effect: the node fails until the end of the tree.
    """

    INPUTS: ClassVar = {"is_global": input_port(BOOL, "Whether a reset has no effect", default=False)}

    _triggered = False

    def initialise(self) -> None:
        """Reset the trigger, if the node is idle."""
        if self.status is Status.INVALID and not self.read("is_global"):
            self._triggered = False

    def advance(self) -> Ticks:
        """Tick the child unless it has ended before."""
        if self._triggered:
            return Status.FAILURE
        status = yield from self.tick_child()
        self._triggered = status in (Status.SUCCESS, Status.FAILURE)
        return status


class Precondition(Scripted, Decoration):
    """Ticks its child if a script is true, and returns the child's status; otherwise returns *else*.

    The script is not evaluated while the child is RUNNING.
    """

    SCRIPTS: ClassVar = ("if",)
    INPUTS: ClassVar = {"else": input_port(STATUS, "Status if the script is false", default=Status.FAILURE)}

    def next_tick_time(self) -> float:
        """Return that the script has to be polled, unless the child is RUNNING."""
        return super().next_tick_time() if self.child.status is Status.RUNNING else EACH_PERIOD

    def advance(self) -> Ticks:
        """Run the script, or tick the RUNNING child."""
        if self.child.status is not Status.RUNNING and not self.holds("if"):
            otherwise: Status = self.read("else")
            return otherwise
        return (yield from self.tick_child())


_MILLISECONDS: Final = 1000


class Delay(Decoration):
    """Ticks its child after a delay, and returns the child's status."""

    INPUTS: ClassVar = {"delay_msec": input_port(UNSIGNED, "Simulated milliseconds")}

    def initialise(self) -> None:
        """Start the delay."""
        self._begins = now() + self.read("delay_msec") / _MILLISECONDS
        self._waits = True

    def next_tick_time(self) -> float:
        """Return when the child is due."""
        return self._begins if self.status is Status.RUNNING and self._waits else super().next_tick_time()

    def advance(self) -> Ticks:
        """Tick the child after the delay."""
        if self._waits and not reached(self._begins):
            return Status.RUNNING
        self._waits = False
        return (yield from self.tick_child())


class Timeout(Decoration):
    """Returns its child's status. A child that is RUNNING after the time limit is halted, and the node fails.

    A child that ends exactly at the limit counts as in time.
    """

    INPUTS: ClassVar = {"msec": input_port(UNSIGNED, "Simulated milliseconds; 0 for no limit")}

    def initialise(self) -> None:
        """Start the time limit."""
        self.feedback_message = ""
        limit = self.read("msec")
        self._ends = now() + limit / _MILLISECONDS if limit > 0 else math.inf

    def next_tick_time(self) -> float:
        """Return the end of the time limit."""
        return self._ends if self.status is Status.RUNNING else super().next_tick_time()

    def advance(self) -> Ticks:
        """Tick the child, and check the time limit."""
        status = yield from self.tick_child()
        if status is Status.RUNNING and self._ends < math.inf and reached(self._ends):
            self.feedback_message = "timed out"
            return Status.FAILURE
        return status


class _Changed(Decoration):
    """Ticks its child and maps its status; RUNNING and skipped are unchanged."""

    becomes: ClassVar[Mapping[Status, Status]]

    def advance(self) -> Ticks:
        """Tick the child, and map its status."""
        status = yield from self.tick_child()
        return self.becomes.get(status, status)


class Inverter(_Changed):
    """Succeeds when its child fails, and fails when its child succeeds."""

    becomes = MappingProxyType({Status.SUCCESS: Status.FAILURE, Status.FAILURE: Status.SUCCESS})


class ForceSuccess(_Changed):
    """Succeeds when its child has ended, whatever its status."""

    becomes = MappingProxyType({Status.FAILURE: Status.SUCCESS})


class ForceFailure(_Changed):
    """Fails when its child has ended, whatever its status."""

    becomes = MappingProxyType({Status.SUCCESS: Status.FAILURE})


FAMILY = Family.of_module(__name__)
