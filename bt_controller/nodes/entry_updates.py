"""Detection of writes to an entry of the blackboard."""

from __future__ import annotations

from typing import ClassVar

from py_trees.blackboard import Blackboard

from bt_controller.core.node import Node


class Watching(Node):
    """A node that looks whether the entry of its port ``entry`` has been written since it looked before."""

    KEYS: ClassVar = ("entry",)

    _seen = 0

    def updated(self) -> bool:
        """Return whether it has, also with the value that it had; the first look counts from the beginning."""
        key = self._get_blackboard_key("entry")
        if key not in Blackboard.storage:
            return False
        before, self._seen = self._seen, Blackboard.storage.writes[key]  # type: ignore[attr-defined]  # `Entries`
        return before != self._seen
