"""Coverage of behavior trees: which nodes were ticked, how they ended, and what never happened.

`outcomes` names what can happen to a node, `kinds` knows classes of nodes, `possible` says what can happen to a node at
its place in a tree, `recording` listens to a tree while it is ticked, `tree_coverage` counts, merges and keeps.
"""

from __future__ import annotations

from bt_controller.coverage.node_coverage import NodeCoverage
from bt_controller.coverage.tree_coverage import CoverageError, TreeCoverage

__all__ = ["CoverageError", "NodeCoverage", "TreeCoverage"]
