"""What the runs of a search have covered of a tree: each worker sends what it has not seen before."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from bt_controller.coverage import TreeCoverage
from bt_controller.coverage.files import write_coverage
from bt_controller.coverage.summary import share_of
from hmrsim.experiments.running.coverages import packed, unpacked

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

FILE: Final = "coverage.json"
"""The name of the file in the folder of results."""


class Novelty:
    """Keeps back the coverage of runs that have ticked nothing that was not ticked before, in this process."""

    def __init__(self) -> None:
        self._seen: dict[str, None] = {}

    def new_in(self, coverage: TreeCoverage) -> bytes:
        """Return the coverage of a run in few bytes; empty if it has nothing new."""
        keys = coverage.keys()
        if self._seen.keys() >= keys:
            return b""
        self._seen |= dict.fromkeys(keys)
        return packed(coverage)


class Covered:
    """What was covered by all runs together; counts are of the runs that have brought something new."""

    def __init__(self) -> None:
        self._all = TreeCoverage()

    def take(self, coverages: Iterable[bytes]) -> None:
        """Add what some runs have covered; an empty one has nothing new."""
        for coverage in coverages:
            if coverage:
                self._all.merge(unpacked(coverage))

    @property
    def share(self) -> str:
        """How much of the trees is covered, in words; empty without a tree."""
        nodes = [node for tree in self._all.trees for node in self._all.nodes(tree)]
        return str(share_of(nodes)) if nodes else ""

    def never(self) -> tuple[str, ...]:
        """Return what no run has made the nodes of the trees do, a line for each node."""
        return tuple(
            f"{node.path}: never {' or '.join(words)}"
            for tree in self._all.trees
            for node in self._all.nodes(tree)
            if (words := node.never)
        )

    def write(self, folder: Path) -> None:
        """Write it as a file that ``bt-controller coverage`` reads, if there is a tree.

        Raises:
            OutputError: It can't be written.
        """
        if self._all.trees:
            write_coverage("coverage", folder / FILE, self._all)
