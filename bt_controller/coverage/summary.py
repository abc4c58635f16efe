"""How much of trees is covered, and what never happened."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from bt_controller.coverage.outcomes import ENDINGS, RUNNING, SKIPPED

if TYPE_CHECKING:
    from bt_controller.coverage.node_coverage import NodeCoverage
    from bt_controller.coverage.tree_coverage import TreeCoverage


@dataclass(frozen=True)
class Share:
    """A share of the outcomes that can happen.

    Attributes:
        seen: How many have happened.
        possible: How many can happen.
    """

    seen: int
    possible: int

    def __str__(self) -> str:
        """Return the numbers and the share."""
        share = f" ({self.seen / self.possible:.0%})" if self.possible else ""
        return f"{self.seen} of {self.possible} outcomes{share}"

    def to_json(self) -> dict[str, Any]:
        """Return the share as JSON values; null for the share of nothing."""
        share = self.seen / self.possible if self.possible else None
        return {"seen": self.seen, "possible": self.possible, "share": share}


def share_of(nodes: Sequence[NodeCoverage]) -> Share:
    """Return how much of some nodes is covered."""
    possible = sum(len(node.points) for node in nodes)
    return Share(possible - sum(len(node.missing) for node in nodes), possible)


def goal_ends(node: NodeCoverage) -> dict[str, int]:
    """Return how often a leaf's goals have ended otherwise than by success or a cancel, by outcome."""
    return {outcome: count for outcome, count in node.seen.items() if outcome not in (*ENDINGS, RUNNING, SKIPPED)}


def summary(coverage: TreeCoverage) -> dict[str, Any]:
    """Return what was covered and what never happened, as JSON values."""
    return {
        "trees": [
            {
                "name": name,
                "runs": coverage.runs(name),
                "covered": share_of(coverage.nodes(name)).to_json(),
                "nodes": [_plain(node) for node in coverage.nodes(name)],
            }
            for name in coverage.trees
        ]
    }


def _plain(node: NodeCoverage) -> dict[str, Any]:
    told = {"path": node.path, "kind": node.kind, "ticks": node.ticks, "counts": node.seen, "never": node.never}
    return {**told, "origin": node.origin} if node.origin else told
