"""The attributes ``_skipIf``, ``_onSuccess`` and so on that any node of an XML tree may have."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar, Final

from py_trees.common import Status

from bt_controller.core.node import EACH_PERIOD, Decoration, Ticks
from bt_controller.scripting.ports import Scripted

if TYPE_CHECKING:
    from bt_controller.core.node import Node
    from bt_controller.scripting.parser import Script

_BEFORE: Final = (("_failureIf", Status.FAILURE), ("_successIf", Status.SUCCESS), ("_skipIf", Status.INVALID))
"""The attributes in BehaviorTree.CPP's order of evaluation."""

_AFTER: Final[Mapping[Status, tuple[str, ...]]] = MappingProxyType(
    {Status.SUCCESS: ("_onSuccess", "_post"), Status.FAILURE: ("_onFailure", "_post")}
)

ATTRIBUTES: Final = (*(name for name, _ in _BEFORE), "_while", "_onHalted", "_onFailure", "_onSuccess", "_post")


def conditioned(scripts: Mapping[str, Script]) -> type[Node]:
    """Return the decoration that gives a node these scripts, by attribute; `ATTRIBUTES` are all there are."""
    return ScriptConditions.bind(scripts)


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
        """Halt the child."""
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
