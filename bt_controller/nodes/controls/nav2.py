"""Nav2's controls: its sequences, RecoveryNode and RoundRobin; and BatteryGuard."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

from py_trees.blackboard import Blackboard
from py_trees.common import Status

from bt_controller.behaviours.battery_guard import BatteryGuardNode
from bt_controller.core.node import EACH_PERIOD, Control, Ticks
from bt_controller.core.ports import BOOL, INT, input_port
from bt_controller.core.sim_time import TurnCounter
from bt_controller.nodes import Family

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour


class NonblockingSequence(Control):
    """Ticks all its children at each tick, including those that have ended.

    Fails as soon as one fails, and halts the others; succeeds when all succeed in one tick; else it is RUNNING. If all
    children are skipped, the node is skipped.
    """

    def next_ticked(self) -> Sequence[Behaviour]:
        """Return all children."""
        return self.children if self.status is Status.RUNNING else ()

    def advance(self) -> Ticks:
        """Tick all children, also those that have ended."""
        for child in self.children:
            yield from child.tick()
            if child.status is Status.FAILURE:
                return Status.FAILURE
        statuses = [child.status for child in self.children]
        if Status.RUNNING in statuses:
            return Status.RUNNING
        return Status.SUCCESS if Status.SUCCESS in statuses else Status.INVALID


class PersistentSequence(Control):
    """A sequence that continues with the child ``current_child_idx``, even after it was halted.

    A child that succeeds or is skipped is followed by the next one. When one fails, or all have been ticked, the index
    is reset to 0.
    """

    INPUTS: ClassVar = {
        "current_child_idx": input_port(INT, "Index of the current child, from 0; also written", default=0)
    }

    def advance(self) -> Ticks:
        """Tick the children from the current one."""
        index = self.read("current_child_idx")
        while index < len(self.children):
            child = self.children[index]
            yield from child.tick()
            if child.status is Status.RUNNING:
                return Status.RUNNING
            if child.status is Status.FAILURE:
                self._note(0)
                return Status.FAILURE
            index += 1
            self._note(index)
        self._note(0)
        return Status.SUCCESS

    def _note(self, index: int) -> None:
        """Write to the input port: ports of py_trees have one direction only."""
        Blackboard.set(self._get_blackboard_key("current_child_idx"), index)


class PipelineSequence(Control):
    """Ticks its children in order, up to the last one that was reached, including those that have ended.

    A RUNNING child does not block the following ones if one of them was reached before. Fails when a child fails;
    succeeds when the last child does and none before it has failed. If all children are skipped, the node is skipped.
    """

    def initialise(self) -> None:
        """Begin with no child reached."""
        self._reached = 0

    def next_ticked(self) -> Sequence[Behaviour]:
        """Return the children up to the last one that was reached."""
        return self.children[: self._reached + 1] if self.status is Status.RUNNING else ()

    def advance(self) -> Ticks:
        """Tick the children up to the first RUNNING one after those that were reached before."""
        skipped = 0
        for index, child in enumerate(self.children):
            yield from child.tick()
            match child.status:
                case Status.FAILURE:
                    return Status.FAILURE
                case Status.RUNNING if index >= self._reached:
                    self._reached = index
                    return Status.RUNNING
                case Status.INVALID:
                    skipped += 1
        return Status.INVALID if skipped == len(self.children) else Status.SUCCESS


class RecoveryNode(Control):
    """Succeeds when its first child does. When that fails, ticks the second, and if that succeeds, the first again.

    Fails when the second child fails or is skipped, or when the first has failed once more than the number of retries.
    If the first child is skipped, the node is skipped. A halt resets the number of retries. After a thousand retries at
    one instant the next one follows a period later.
    """

    INPUTS: ClassVar = {"number_of_retries": input_port(INT, "Number of retries", default=1)}
    least = most = 2

    def initialise(self) -> None:
        """Begin with the first child."""
        self._retries = 0
        self._recovers = False
        self._turns = TurnCounter()

    def next_tick_time(self) -> float:
        """Return that the node needs polling if no child is RUNNING, as the first one is ticked again."""
        return super().next_tick_time() if self.next_ticked() else EACH_PERIOD

    def advance(self) -> Ticks:
        """Tick the first child, or the recovery after its failure."""
        first, second = self.children
        while True:
            child = second if self._recovers else first
            if child is first and first.status is not Status.RUNNING and not self._turns.count():
                return Status.RUNNING
            yield from child.tick()
            match child.status, self._recovers:
                case (Status.RUNNING, _) | (Status.SUCCESS | Status.INVALID, False):
                    return child.status
                case Status.FAILURE | Status.INVALID, True:
                    return Status.FAILURE
                case Status.FAILURE, False:
                    if self._retries >= self.read("number_of_retries"):
                        return Status.FAILURE
                    self._recovers = True
                case _:
                    self._retries += 1
                    self._recovers = False
                    self.reset(first)
                    self.reset(second)


class RoundRobin(Control):
    """Ticks its children in order until one succeeds; the next time it continues with the child after that.

    Fails when all children have failed in a row. The first child follows the last one only with ``wrap_around``:
    otherwise the node fails once after the last child, and then begins with the first. If all children are skipped, so
    is the node. After a halt it begins with the first child.

    This is the documented behavior; Nav2's implementation fails when the last child has ended, whatever its status.
    """

    INPUTS: ClassVar = {"wrap_around": input_port(BOOL, "Whether the first child follows the last one", default=False)}

    _next = 0
    """The index of the current child."""
    _failed = 0
    """The number of consecutive failures."""

    def advance(self) -> Ticks:
        """Tick the children from the current one."""
        count, skipped = len(self.children), 0
        while self._next < count and self._failed + skipped < count:
            child = self.children[self._next]
            yield from child.tick()
            if child.status is Status.RUNNING:
                return Status.RUNNING
            self._next += 1
            if self.read("wrap_around"):
                self._next %= count
            match child.status:
                case Status.SUCCESS:
                    self._failed = 0
                    return Status.SUCCESS
                case Status.FAILURE:
                    self._failed += 1
                case _:
                    skipped += 1
        self._next = self._failed = 0
        return Status.INVALID if skipped == count else Status.FAILURE

    def terminate(self, new_status: Status) -> None:
        """Begin with the first child if the node is halted; a reset after its end changes nothing."""
        if new_status is Status.INVALID and self.status is Status.RUNNING:
            self._next = self._failed = 0


class BatteryGuard(BatteryGuardNode):
    """Suspends its first child, the mission, to charge by its second when the battery is low; then resumes it.

    The mission and its time stand still meanwhile. Its goals are canceled, and the second child is ticked when all of
    them have ended; completed steps are not repeated. The mission resumes when the second child has succeeded and the
    battery has reached its target charge; a battery that is still charging is waited for. First the robot drives back
    to where it was, unless the mission resumes with a drive.

    Succeeds when the mission does. Fails when the mission, the charging or the way back fails, and when the battery
    was charged three times without a completed goal of the mission in between: then a charge is too small for it.
    """


FAMILY = Family.of_module(__name__)
