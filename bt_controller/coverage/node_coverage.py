"""The coverage of a node."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

from bt_controller.coverage.outcomes import ENDINGS, FAILURE, RUNNING, SKIPPED, SUCCESS, TICKED, WORDS


@dataclass
class NodeCoverage:
    """What happened to a node, in all trees that have it at this path.

    Attributes:
        place: Which child of each parent, from the root.
        path: The names from the root; siblings of one name are numbered, and the robot's own name is ``{robot}``.
        kind: Its class.
        origin: File and line, if it comes from a file.
        possible: What can happen to it, as far as that is known without running it.
        counts: How often each outcome was seen: statuses by ticks, the other outcomes each time that they happen.
    """

    place: tuple[int, ...]
    path: str
    kind: str
    origin: str = ""
    possible: frozenset[str] = frozenset()
    counts: Counter[str] = field(default_factory=Counter)

    @property
    def name(self) -> str:
        """The last part of the path."""
        return self.path.rpartition("/")[2] if self.place else self.path

    @property
    def ticks(self) -> int:
        """The number of its ticks."""
        return sum(self.counts[status] for status in (SUCCESS, FAILURE, RUNNING, SKIPPED))

    @property
    def points(self) -> tuple[str, ...]:
        """The outcomes that count for the share: those that can happen, and those that were seen nevertheless."""
        return tuple(each for each in ENDINGS if each in self.possible or self.counts[each])

    @property
    def missing(self) -> tuple[str, ...]:
        """The outcomes that count, and never happened."""
        return tuple(each for each in self.points if not self.counts[each])

    @property
    def seen(self) -> dict[str, int]:
        """How often each outcome was seen, in order; those that were not are left out."""
        return {outcome: count for outcome, count in sorted(self.counts.items()) if count}

    @property
    def ends(self) -> dict[str, int]:
        """`seen` without RUNNING."""
        return {outcome: count for outcome, count in self.seen.items() if outcome != RUNNING}

    @property
    def never(self) -> list[str]:
        """What it has never done, although it can: ``ticked``, or `WORDS`."""
        return [*([] if self.ticks else [TICKED]), *(WORDS[outcome] for outcome in self.missing)]

    def merge(self, other: NodeCoverage) -> None:
        """Add what happened to the node elsewhere."""
        self.place = min(self.place, other.place)
        self.origin = self.origin or other.origin
        self.possible |= other.possible
        self.counts.update(other.counts)
