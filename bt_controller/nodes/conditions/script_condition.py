"""BehaviorTree.CPP's ScriptCondition: a script as a condition."""

from __future__ import annotations

from typing import ClassVar

from py_trees.common import Status

from bt_controller.core.node import Condition
from bt_controller.nodes import Family
from bt_controller.scripting.ports import Scripted


class ScriptCondition(Scripted, Condition):
    """Runs a script; succeeds if its value is true, and fails otherwise."""

    SCRIPTS: ClassVar = ("code",)

    def update(self) -> Status:
        """Run the script."""
        return Status.SUCCESS if self.holds("code") else Status.FAILURE


FAMILY = Family("script_condition", {"ScriptCondition": ScriptCondition})
