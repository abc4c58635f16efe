"""BehaviorTree.CPP's actions: blackboard entries, scripts, constant results and sleep."""

from __future__ import annotations

from typing import ClassVar, Final

from py_trees.blackboard import Blackboard
from py_trees.common import Status

from bt_controller.core.node import EACH_PERIOD, Leaf, PortError
from bt_controller.core.ports import ANY, UNSIGNED, input_port, output_port
from bt_controller.core.sim_time import now, reached
from bt_controller.nodes import Family
from bt_controller.scripting.scripted import Scripted


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


class AlwaysSuccess(Leaf):
    """Succeeds at once, whenever it is ticked."""

    def update(self) -> Status:
        """Return the status."""
        return Status.SUCCESS


class AlwaysFailure(Leaf):
    """Fails at once, whenever it is ticked."""

    def update(self) -> Status:
        """Return the status."""
        return Status.FAILURE


_MILLISECONDS: Final = 1000


class Sleep(Leaf):
    """Runs for a duration, and then succeeds."""

    INPUTS: ClassVar = {"msec": input_port(UNSIGNED, "Simulated milliseconds")}

    def initialise(self) -> None:
        """Start the duration of the sleep."""
        self._ends = now() + self.read("msec") / _MILLISECONDS

    def next_tick_time(self) -> float:
        """Return the end of the duration; a node that has ended sleeps again when it is ticked again."""
        return self._ends if self.status is Status.RUNNING else EACH_PERIOD

    def update(self) -> Status:
        """Check the time."""
        return Status.SUCCESS if reached(self._ends) else Status.RUNNING


FAMILY = Family.of_module(__name__)
