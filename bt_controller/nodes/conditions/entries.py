"""BehaviorTree.CPP's conditions on the blackboard: ScriptCondition, WasEntryUpdated."""

from __future__ import annotations

from typing import ClassVar

from py_trees.common import Status

from bt_controller.core.node import Condition
from bt_controller.core.ports import ANY, input_port
from bt_controller.nodes import Family
from bt_controller.nodes.entry_updates import Watching
from bt_controller.scripting.ports import Scripted


class ScriptCondition(Scripted, Condition):
    """Runs a script; succeeds if its value is true, and fails otherwise."""

    SCRIPTS: ClassVar = ("code",)

    def update(self) -> Status:
        """Run the script."""
        return Status.SUCCESS if self.holds("code") else Status.FAILURE


class WasEntryUpdated(Watching, Condition):
    """Succeeds if an entry was written since the last tick, even with the same value; else fails."""

    INPUTS: ClassVar = {"entry": input_port(ANY, "Key of the entry, with or without braces")}

    def update(self) -> Status:
        """Check the entry."""
        return Status.SUCCESS if self.updated() else Status.FAILURE


FAMILY = Family.of("entries", ScriptCondition, WasEntryUpdated)
