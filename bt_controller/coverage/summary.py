"""How much of trees is covered, and what never happened."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

from bt_controller.coverage.outcomes import CANCELED, ENDINGS, FAILURE, RECOVERED, RUNNING, SKIPPED, SUCCESS

if TYPE_CHECKING:
    from bt_controller.coverage.node_coverage import NodeCoverage
    from bt_controller.coverage.tree_coverage import TreeCoverage

WORDS: Final[Mapping[str, str]] = MappingProxyType(
    {SUCCESS: "succeeded", FAILURE: "failed", CANCELED: "canceled", RECOVERED: "recovered"}
)
"""What a node has done, by outcome."""

TICKED: Final = "ticked"


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


def never(node: NodeCoverage) -> list[str]:
    """Return what a node has never done, although it can: ``ticked``, or `WORDS`."""
    return [*([] if node.ticks else [TICKED]), *(WORDS[outcome] for outcome in node.missing)]


def goal_ends(node: NodeCoverage) -> dict[str, int]:
    """Return how often a leaf's goals have ended otherwise than by success or a cancel, by outcome."""
    ends = {name: count for name, count in node.counts.items() if name not in (*ENDINGS, RUNNING, SKIPPED) and count}
    return dict(sorted(ends.items()))


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
    counts = {outcome: count for outcome, count in sorted(node.counts.items()) if count}
    told = {"path": node.path, "kind": node.kind, "ticks": node.ticks, "counts": counts, "never": never(node)}
    return {**told, "origin": node.origin} if node.origin else told
