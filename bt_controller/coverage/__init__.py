"""Coverage of behavior trees: which nodes were ticked, how they ended, and what never happened.

`node_coverage` counts the outcomes of a node, `kinds` knows which outcomes are possible at a place in a tree,
`tree_coverage` counts while a tree is ticked and merges counts, and `files` reads and writes them.
"""

from __future__ import annotations

from bt_controller.coverage.node_coverage import NodeCoverage
from bt_controller.coverage.tree_coverage import CoverageError, TreeCoverage

__all__ = ["CoverageError", "NodeCoverage", "TreeCoverage"]
