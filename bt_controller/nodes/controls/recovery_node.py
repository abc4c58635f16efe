"""Nav2's RecoveryNode: try, recover, try again."""

from __future__ import annotations

from typing import ClassVar

from py_trees.common import Status

from bt_controller.core.node import EACH_PERIOD, Control, Ticks
from bt_controller.core.ports import INT, input_port
from bt_controller.nodes import Family
from bt_controller.nodes.turns import TurnCounter


class RecoveryNode(Control):
    """Succeeds when its first child does. When that fails, ticks the second, and if that succeeds, the first again.

    Fails when the second child fails or is skipped, or when the first has failed once more than the number of retries.
    If the first child is skipped, so is the node. A halt resets the number of retries. After a thousand retries at one
    instant the next one follows a period later.
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
        """Tick the current child."""
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


FAMILY = Family.of("recovery_node", RecoveryNode)
