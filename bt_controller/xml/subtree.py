"""The use of one tree in another."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bt_controller.core.node import Decoration

if TYPE_CHECKING:
    from collections.abc import Generator

    from py_trees.behaviour import Behaviour
    from py_trees.common import Status


class SubTree(Decoration):
    """Runs another tree with its own blackboard, and returns its status."""

    def advance(self) -> Generator[Behaviour, None, Status]:
        """Tick the tree."""
        status: Status = yield from self.tick_child()
        return status
