"""BehaviorTree.CPP's Script: a script that changes the blackboard."""

from __future__ import annotations

from typing import ClassVar

from py_trees.common import Status

from bt_controller.core.node import Leaf
from bt_controller.nodes import Family
from bt_controller.scripting.ports import Scripted


class Script(Scripted, Leaf):
    """Runs a script, and succeeds whatever its value."""

    SCRIPTS: ClassVar = ("code",)

    def update(self) -> Status:
        """Run the script."""
        self.run("code")
        return Status.SUCCESS


FAMILY = Family("script", {"Script": Script})
