"""Nodes with scripts: their own, and those of the attributes ``_skipIf``, ``_onSuccess`` and so on of any node.

The names in a script become ports, so that a file's remappings apply to them. Each name is an input port ``name``, and
one that a script changes is also an output port ``name>``. The builder connects both to the same key.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Final, Self

from py_trees.common import Status

from bt_controller.core.node import EACH_PERIOD, Decoration, Node, Ticks
from bt_controller.core.ports import ANY, input_port, output_port
from bt_controller.scripting.parser import ScriptError
from bt_controller.scripting.values import truth

if TYPE_CHECKING:
    from bt_controller.scripting.parser import Script


class Scripted(Node):
    """A node that runs scripts; `bind` makes a class with them.

    Attributes:
        SCRIPTS: The attributes that are scripts, not ports.
        scripts: The parsed scripts by attribute.
    """

    SCRIPTS: ClassVar[tuple[str, ...]] = ()

    scripts: ClassVar[Mapping[str, Script]] = MappingProxyType({})

    @classmethod
    def bind(cls, scripts: Mapping[str, Script]) -> type[Self]:
        """Return a class that has these scripts, by attribute, and ports for their names.

        Raises:
            ScriptError: An entry is named as one of the node's own ports.
        """
        inputs, outputs = dict(cls.INPUTS), dict(cls.OUTPUTS)
        for script in scripts.values():
            for name in script.names:
                if name in {**cls.INPUTS, **cls.OUTPUTS}:
                    raise ScriptError(
                        f"script {script.text!r:.200}: {name!r} is a port of {cls.__name__}, not an entry"
                    )
                inputs[name] = input_port(ANY, f"Entry {name} of a script", required=False)
            for name in script.changed:
                outputs[f"{name}>"] = output_port(ANY, f"Entry {name} of a script, when it is changed")
        parts: dict[str, Any] = {"__doc__": cls.__doc__, "__module__": cls.__module__}
        parts |= {"INPUTS": inputs, "OUTPUTS": outputs, "scripts": dict(scripts)}
        return type(cls.__name__, (cls,), parts)

    def run(self, attribute: str) -> Any:
        """Run a script, and return its value.

        Raises:
            ScriptError: An entry is missing, or an operator can't be used on a value.
        """
        try:
            return self.scripts[attribute].run(self)
        except ScriptError as error:
            raise ScriptError(f"{self._whose_script()}: {error}") from None

    def holds(self, attribute: str) -> bool:
        """Return whether the value of a script counts as true.

        Raises:
            ScriptError: It is neither true nor false, or the script can't be run.
        """
        value = self.run(attribute)
        try:
            return truth(value)
        except ValueError as error:
            raise ScriptError(
                f"{self._whose_script()}: script {self.scripts[attribute].text!r:.200}: {error}"
            ) from None

    def get(self, name: str) -> Any:
        """Return the value of an entry; None if there is none."""
        return self.entry(name)

    def set(self, name: str, value: Any) -> None:
        """Change or create an entry."""
        self.write(f"{name}>", value)

    def _whose_script(self) -> str:
        return f"{self.name} ({self.origin})" if self.origin else self.name


_BEFORE: Final = (("_failureIf", Status.FAILURE), ("_successIf", Status.SUCCESS), ("_skipIf", Status.INVALID))
"""The attributes in BehaviorTree.CPP's order of evaluation."""

_AFTER: Final[Mapping[Status, tuple[str, ...]]] = MappingProxyType(
    {Status.SUCCESS: ("_onSuccess", "_post"), Status.FAILURE: ("_onFailure", "_post")}
)

ATTRIBUTES: Final = (*(name for name, _ in _BEFORE), "_while", "_onHalted", "_onFailure", "_onSuccess", "_post")


class ScriptConditions(Scripted, Decoration):
    """Runs scripts before and after its child.

    ``_failureIf``, ``_successIf`` and ``_skipIf`` are looked at in this order when the child is idle, never while it
    runs: the first that is true says how the node ends, without a tick of the child. ``_while`` is looked at after
    them, and at each tick while the child runs; when it is false, the child is halted and the node is skipped.

    ``_onHalted`` is run when a running child is halted, ``_onSuccess`` and ``_onFailure`` when the node ends so, also
    if a condition said it; ``_post`` after them.
    """

    SCRIPTS: ClassVar = ATTRIBUTES

    def next_tick_time(self) -> float:
        """Return that ``_while`` has to be polled while the child is RUNNING."""
        return EACH_PERIOD if "_while" in self.scripts else super().next_tick_time()

    def advance(self) -> Ticks:
        """Tick the child, unless a condition determines the status."""
        status = self._before()
        if status is None:
            # Not by `tick_child`: the node's parent decides whether a child that has ended becomes idle.
            yield from self.child.tick()
            status = self.child.status
        for attribute in _AFTER.get(status, ()):
            self._run_any(attribute)
        return status

    def terminate(self, new_status: Status) -> None:
        """Halt the child, and run ``_onHalted``."""
        if new_status is Status.INVALID:
            self._halt()

    def _before(self) -> Status | None:
        """Return the status that a condition determines; None to tick the child."""
        if self.status is Status.INVALID:
            for attribute, status in _BEFORE:
                if attribute in self.scripts and self.holds(attribute):
                    return status
        elif self.status is not Status.RUNNING:
            return None
        if "_while" not in self.scripts or self.holds("_while"):
            return None
        self._halt()
        return Status.INVALID

    def _halt(self) -> None:
        if self.child.status is Status.RUNNING:
            self.halt(self.child)
            self._run_any("_onHalted")

    def _run_any(self, attribute: str) -> None:
        if attribute in self.scripts:
            self.run(attribute)
