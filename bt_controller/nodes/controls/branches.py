"""BehaviorTree.CPP's controls that choose a branch: IfThenElse, WhileDoElse, Switch2 to Switch6, TryCatch."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar, Final

from py_trees.common import Status

from bt_controller.core.node import EACH_PERIOD, Control, Ticks
from bt_controller.core.ports import ANY, BOOL, input_port
from bt_controller.nodes import Family
from bt_controller.scripting.values import same

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour


class IfThenElse(Control):
    """Ticks its second child if the first succeeds, its third if the first fails, and returns that child's status.

    The first child is not ticked again while another is RUNNING. Without a third child the node fails if the first
    does. If the first child is skipped, the node is skipped.
    """

    least, most = 2, 3

    def initialise(self) -> None:
        """Start with the condition, not with a branch."""
        self._branch = 0

    def advance(self) -> Ticks:
        """Tick the condition or the branch."""
        if self._branch == 0:
            condition = self.children[0]
            yield from condition.tick()
            if condition.status in (Status.RUNNING, Status.INVALID):
                return condition.status
            self._branch = 1 if condition.status is Status.SUCCESS else 2
        if self._branch == len(self.children):
            return Status.FAILURE
        branch = self.children[self._branch]
        yield from branch.tick()
        return branch.status


class WhileDoElse(Control):
    """Ticks its second child while the first succeeds, its third while the first fails, and returns its status.

    The first child is ticked at each tick; when its status changes, the other branch is halted. While it is RUNNING,
    no branch is ticked. Without a third child the node fails if the first does. If the first child is skipped, so is
    the node.
    """

    least, most = 2, 3

    def next_ticked(self) -> Sequence[Behaviour]:
        """Return the condition and the RUNNING branch."""
        condition, *branches = self.children
        running = [branch for branch in branches if branch.status is Status.RUNNING]
        return [condition, *running] if running else super().next_ticked()

    def advance(self) -> Ticks:
        """Tick the condition and the branch."""
        condition, *branches = self.children
        yield from condition.tick()
        if condition.status in (Status.RUNNING, Status.INVALID):
            return condition.status
        meant = 0 if condition.status is Status.SUCCESS else 1
        for branch in branches[1 - meant : 2 - meant]:
            self.reset(branch)
        if meant == len(branches):
            return Status.FAILURE
        yield from branches[meant].tick()
        return branches[meant].status


class _Switch(Control):
    """Ticks the child whose case equals the variable, or else the last child, and returns that child's status.

    Case 1 is the first child's, and so on. Values are compared as strings or as numbers, at each tick; a child that is
    no longer selected is halted. If the variable has no value, the last child is selected.
    """

    def next_tick_time(self) -> float:
        """Return that the variable has to be polled."""
        return EACH_PERIOD

    def advance(self) -> Ticks:
        """Tick the selected child, and halt the others."""
        meant = self._meant()
        for child in self.children:
            if child is not meant:
                self.reset(child)
        yield from meant.tick()
        return meant.status

    def _meant(self) -> Behaviour:
        *children, default = self.children
        variable = self.read("variable")
        if variable is None:
            return default
        for number, child in enumerate(children, start=1):
            case = self.read(f"case_{number}")
            if case is not None and same(variable, case):
                return child
        return default


def _switch(cases: int) -> type[_Switch]:
    inputs = {"variable": input_port(ANY, "Value to compare with the cases", required=False)}
    for number in range(1, cases + 1):
        inputs[f"case_{number}"] = input_port(ANY, f"Value for child {number}", required=False)
    parts = {
        "__doc__": _Switch.__doc__,
        "__module__": __name__,
        "INPUTS": inputs,
        "least": cases + 1,
        "most": cases + 1,
    }
    return type(f"Switch{cases}", (_Switch,), parts)


_CASES: Final = range(2, 7)


class TryCatch(Control):
    """Ticks all children except the last as a sequence. When one of them fails, ticks the last one, and then fails.

    The node fails whatever the status of the last child. Skipped children are ignored; if all except the last are
    skipped, the node is skipped. With *catch_on_halt* the last child is also ticked once if the node is halted.
    """

    INPUTS: ClassVar = {"catch_on_halt": input_port(BOOL, "Whether a halt counts as a failure", default=False)}
    least = 2

    def initialise(self) -> None:
        """Begin with the first child."""
        self._turn = 0
        self._counts = self._catches = False

    def advance(self) -> Ticks:
        """Tick the current child and the following ones."""
        *tried, catch = self.children
        while self._turn < len(tried) and not self._catches:
            child = tried[self._turn]
            yield from child.tick()
            if child.status is Status.RUNNING:
                return Status.RUNNING
            if child.status is Status.FAILURE:
                self._catches = True
            else:
                self._counts = self._counts or child.status is Status.SUCCESS
                self._turn += 1
        if not self._catches:
            return Status.SUCCESS if self._counts else Status.INVALID
        yield from catch.tick()
        return Status.RUNNING if catch.status is Status.RUNNING else Status.FAILURE

    def terminate(self, new_status: Status) -> None:
        """Tick the last child upon a halt, with *catch_on_halt*, and halt it."""
        halted = new_status is Status.INVALID and self.status is Status.RUNNING
        if halted and not self._catches and self._turn < len(self.children) - 1 and self.read("catch_on_halt"):
            catch = self.children[-1]
            catch.tick_once()
            self.reset(catch)


FAMILY = Family.of_module(__name__, *map(_switch, _CASES))
