"""BehaviorTree.CPP's actions on the blackboard: SetBlackboard, UnsetBlackboard, Script."""

from __future__ import annotations

from typing import ClassVar

from py_trees.blackboard import Blackboard
from py_trees.common import Status

from bt_controller.core.node import Leaf, PortError
from bt_controller.core.ports import ANY, input_port, output_port
from bt_controller.nodes import Family
from bt_controller.scripting.ports import Scripted


class SetBlackboard(Leaf):
    """Writes a string or the value of another entry to an entry. Fails if that entry has no value."""

    INPUTS: ClassVar = {"value": input_port(ANY, "The value to write")}
    OUTPUTS: ClassVar = {"output_key": output_port(ANY, "Key of the entry, with or without braces")}
    KEYS: ClassVar = ("output_key",)

    def update(self) -> Status:
        """Write the entry."""
        try:
            self.write("output_key", self.read("value"))
        except PortError as error:
            self.feedback_message = str(error)
            return Status.FAILURE
        self.feedback_message = ""
        return Status.SUCCESS


class UnsetBlackboard(Leaf):
    """Removes an entry, if there is one, and succeeds."""

    OUTPUTS: ClassVar = {"key": output_port(ANY, "Key of the entry, with or without braces")}
    KEYS: ClassVar = ("key",)

    def update(self) -> Status:
        """Remove the entry."""
        Blackboard.unset(self.key_of("key"))
        return Status.SUCCESS


class Script(Scripted, Leaf):
    """Runs a script, and succeeds whatever its value."""

    SCRIPTS: ClassVar = ("code",)

    def update(self) -> Status:
        """Run the script."""
        self.run("code")
        return Status.SUCCESS


FAMILY = Family.of("entries", SetBlackboard, UnsetBlackboard, Script)
