"""The folder of a check's results: a file for each failure with its story and trace, the page, JUnit XML."""

from __future__ import annotations

import json
import re
import tempfile
from typing import TYPE_CHECKING, Final

from hmrsim.errors import OutputError, reason_of
from hmrsim.fault_search.results.junit import junit_text
from hmrsim.fault_search.results.page import page_of
from hmrsim.fault_search.results.repro import repro_text
from hmrsim.fault_search.results.story import LONG, story_of

if TYPE_CHECKING:
    from pathlib import Path

    from hmrsim.fault_search.file.check import Check
    from hmrsim.fault_search.results.finding import Finding
    from hmrsim.fault_search.results.summary import Summary
    from hmrsim.fault_search.running.covered import Covered

FAILURES: Final = "failures"
"""The folder of the failures in that of the results; a later search begins with them."""

_WORD: Final = re.compile(r"[^A-Za-z0-9]+")


class ResultsFolder:
    """A folder of results.

    Args:
        folder: The folder; it is made by `prepare`, or when something is written.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def prepare(self) -> None:
        """Make the folder, so that a search does not find out at its end that it can't be written.

        Raises:
            OutputError: It can't be made, or nothing can be written there.
        """
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=self.folder):
                pass
        except FileExistsError:
            raise OutputError(f"{self.folder}: is a file; expected a folder") from None
        except OSError as error:
            raise OutputError(f"{self.folder}: can't be written: {reason_of(error)}") from None

    def earlier(self) -> list[Path]:
        """Return the files of failures that were found earlier, in order of their names."""
        return sorted((self.folder / FAILURES).glob("*.yaml"))

    def keep(self, check: Check, finding: Finding) -> Path:
        """Write the files of a failure; return that which repeats it.

        Raises:
            OutputError: They can't be written.
        """
        path = self.folder / FAILURES / f"{_name_of(finding)}.yaml"
        self._write(path, repro_text(check, finding, path))
        self._write(path.with_suffix(".txt"), "\n".join(story_of(finding, LONG)) + "\n")
        if finding.told.trace:  # one that hangs has none
            self._write(path.with_suffix(".jsonl"), finding.told.trace)
        return path

    def finish(self, check: Check, summary: Summary, covered: Covered) -> None:
        """Write what is about the whole search: summary, page, JUnit XML, and what of a tree was ticked.

        Raises:
            OutputError: They can't be written.
        """
        self._write(self.folder / "summary.json", json.dumps(summary.to_json(), indent=2) + "\n")
        self._write(
            self.folder / "junit.xml", junit_text(summary.name, summary.exercised, summary.findings, summary.seconds)
        )
        self._write(self.folder / "report.html", page_of(check, summary, self.folder))
        covered.write(self.folder)

    def _write(self, path: Path, text: str) -> None:
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
        except OSError as error:
            raise OutputError(f"{path}: can't be written: {reason_of(error)}") from None


def _name_of(finding: Finding) -> str:
    """Return a name that is the same whenever this failure is found."""
    words = _WORD.sub("_", f"{finding.failure.property} {finding.failure.reason}").strip("_").lower()
    return words[:80]
