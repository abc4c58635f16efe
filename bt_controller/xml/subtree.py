"""The use of one tree in another."""

from __future__ import annotations

from bt_controller.core.node import Decoration, Ticks


class SubTree(Decoration):
    """Runs another tree with its own blackboard, and returns its status."""

    def advance(self) -> Ticks:
        """Tick the tree."""
        return (yield from self.tick_child())
