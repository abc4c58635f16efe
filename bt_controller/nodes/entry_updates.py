"""Detection of writes to an entry of the blackboard."""

from __future__ import annotations

from typing import ClassVar

from py_trees.blackboard import Blackboard

from bt_controller.core.node import Node


class Watching(Node):
    """A node that detects writes to the entry of its port ``entry`` since its last check."""

    KEYS: ClassVar = ("entry",)

    _seen = 0

    def updated(self) -> bool:
        """Return whether the entry was written, even with the same value; at first, since the start of the tree."""
        key = self._get_blackboard_key("entry")
        if key not in Blackboard.storage:
            return False
        before, self._seen = self._seen, Blackboard.storage.writes[key]  # type: ignore[attr-defined]  # `Entries`
        return before != self._seen
