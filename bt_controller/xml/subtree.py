"""Where one tree is used in another."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bt_controller.core.node import Decoration

if TYPE_CHECKING:
    from collections.abc import Generator

    from py_trees.behaviour import Behaviour
    from py_trees.common import Status


class SubTree(Decoration):
    """Does as the tree that it stands for, which has a blackboard of its own."""

    def advance(self) -> Generator[Behaviour, None, Status]:
        """Tick the tree."""
        status: Status = yield from self.tick_child()
        return status
