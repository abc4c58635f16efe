"""BehaviorTree.CPP's Switch2 to Switch6: one child for each value of an entry."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from bt_controller.core.node import EACH_PERIOD, Control, Ticks
from bt_controller.core.ports import ANY, input_port
from bt_controller.nodes import Family
from bt_controller.scripting.values import same

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour


class Switch(Control):
    """Ticks the child whose case equals the variable, or else the last child, and returns that child's status.

    Case 1 is the first child's, and so on. Values are compared as strings or as numbers, at each tick; a child that is
    no longer selected is halted. If the variable has no value, the last child is selected.
    """

    def next_tick_time(self) -> float:
        """Return that the variable has to be polled."""
        return EACH_PERIOD

    def advance(self) -> Ticks:
        """Tick the selected child."""
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


def _switch(cases: int) -> type[Switch]:
    inputs = {"variable": input_port(ANY, "Value to compare with the cases", required=False)}
    for number in range(1, cases + 1):
        inputs[f"case_{number}"] = input_port(ANY, f"Value for child {number}", required=False)
    parts = {"__doc__": Switch.__doc__, "__module__": __name__, "INPUTS": inputs, "least": cases + 1, "most": cases + 1}
    return type(f"Switch{cases}", (Switch,), parts)


_CASES: Final = range(2, 7)

FAMILY = Family("switch", {f"Switch{cases}": _switch(cases) for cases in _CASES})
