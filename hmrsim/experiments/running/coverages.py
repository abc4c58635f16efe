"""The coverage of trees, from workers to files: of each treatment, all runs together."""

from __future__ import annotations

import json
import zlib
from typing import TYPE_CHECKING, Final

from bt_controller.coverage import TreeCoverage
from bt_controller.coverage.files import write_coverage

if TYPE_CHECKING:
    from collections.abc import Sequence

    from hmrsim.experiments.results.row import Row
    from hmrsim.experiments.results.store import Results

FILE: Final = "coverage_{}.json"
"""The name of the file of a treatment, in the folder of results."""


def packed(coverage: TreeCoverage) -> bytes:
    """Return a coverage in few bytes."""
    return zlib.compress(json.dumps(coverage.to_json(), separators=(",", ":")).encode())


def unpacked(coverage: bytes) -> TreeCoverage:
    """Return what was packed."""
    return TreeCoverage.from_json(zlib.decompress(coverage))


class Coverages:
    """The coverage of each treatment, with what earlier processes have made.

    Args:
        results: The results, whose rows say what was counted already.
    """

    def __init__(self, results: Results) -> None:
        self._folder = results.folder
        self._found = {treatment: unpacked(coverage) for treatment, coverage in results.coverages().items()}

    def take(self, rows: Sequence[Row]) -> dict[str, bytes]:
        """Add what some runs have covered; return all that their treatments have, to be kept with the rows."""
        covered = [row for row in rows if row.coverage]
        for row in covered:
            self._found.setdefault(row.run.treatment, TreeCoverage()).merge(unpacked(row.coverage))
        return {
            treatment: packed(self._found[treatment]) for treatment in sorted({row.run.treatment for row in covered})
        }

    def write(self) -> None:
        """Write a file for each treatment.

        Raises:
            OutputError: It can't be written.
            WriteError: The disk is full.
        """
        for treatment, coverage in self._found.items():
            write_coverage("coverage", self._folder / FILE.format(treatment), coverage)
