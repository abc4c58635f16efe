"""The folder of a check's results: a file for each failure with its story and trace, the page, JUnit XML."""

from __future__ import annotations

import json
import math
import os
import re
import shlex
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final
from xml.sax.saxutils import escape, quoteattr

from markupsafe import Markup

from hmrsim import __version__
from hmrsim.errors import OutputError, reason_of
from hmrsim.fault_search.reducer import left_out
from hmrsim.fault_search.story import LONG, events_of, mark_of, passes, story_of
from hmrsim.report.html import page_around, part, templates
from hmrsim.world.writing import block

if TYPE_CHECKING:
    from hmrsim.fault_search.check import Check
    from hmrsim.fault_search.observer import TotalCoverage
    from hmrsim.fault_search.summary import Finding, Summary

FAILURES: Final = "failures"
"""The subfolder of failures; a later search begins with them."""

_WORD: Final = re.compile(r"[^A-Za-z0-9]+")


class ResultsFolder:
    """The folder with the results of a search; it is created by `prepare`, or with the first file."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def prepare(self) -> None:
        """Create the folder before the search, which would otherwise fail at its end.

        Raises:
            OutputError: It can't be created, or is not writable.
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
        """Return the files of earlier failures, in order of their names."""
        return sorted((self.folder / FAILURES).glob("*.yaml"))

    def keep(self, check: Check, finding: Finding) -> Path:
        """Write the files of a failure; return the file that reproduces it.

        Raises:
            OutputError: They can't be written.
        """
        path = self.folder / FAILURES / f"{_name_of(finding)}.yaml"
        self._write(path, repro_text(check, finding, path))
        self._write(path.with_suffix(".txt"), "\n".join(story_of(finding, LONG)) + "\n")
        if finding.outcome.trace:  # one that hangs has none
            self._write(path.with_suffix(".jsonl"), finding.outcome.trace)
        return path

    def finish(self, check: Check, summary: Summary, covered: TotalCoverage) -> None:
        """Write the results of the whole search: summary, page, JUnit XML, and the coverage of a tree.

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
    """Return a file name that depends on the failure alone."""
    words = _WORD.sub("_", f"{finding.failure.property} {finding.failure.reason}").strip("_").lower()
    return words[:80]


def repro_text(check: Check, finding: Finding, path: Path) -> str:
    """Return the text of the file that reproduces a failure; *path* is its future path."""
    story = story_of(finding)
    head = [f"# {line}".rstrip() for line in (f"hmrsim check --repro {path.name}", "", *story[: story.index("", 2)])]
    return "\n".join([*head, "", *_lines(check, finding, path)]) + "\n"


def _lines(check: Check, finding: Finding, path: Path) -> Iterator[str]:
    for key, value in _content(check, finding, path).items():
        yield from block(key, value)


def _content(check: Check, finding: Finding, path: Path) -> dict[str, Any]:
    """Return the content of the file in plain values."""
    controller = check.treatment.model_dump(mode="json", exclude_defaults=True)
    limits = {**check.file.limits.model_dump(mode="json", exclude_none=True), "simulated": check.limit}
    definition = finding.case.definition
    return {
        "repro": 1,
        "name": check.name,
        "failure": {"property": finding.failure.property, "reason": finding.failure.reason},
        "controller": controller,
        "folder": Path(os.path.relpath(check.folder, path.absolute().parent)).as_posix(),
        **({} if check.file.world_seed is None else {"world_seed": check.file.world_seed}),
        "limits": limits,
        **({"trace": finding.trace_hash} if finding.trace_hash else {}),
        "schedule": [dict(injection.spec) for injection in finding.schedule],
        "properties": check.properties.model_dump(mode="json", by_alias=True, exclude_defaults=True),
        **({"left_out": text} if definition is not None and (text := left_out(check.definition, definition)) else {}),
        "world": check.definition if definition is None else dict(definition),
    }


def junit_text(name: str, properties: Mapping[str, int], findings: Sequence[Finding], seconds: float) -> str:
    """Return a JUnit document with a test case for each property.

    *properties* has the number of runs that exercised each, and *seconds* are the wall seconds of the search.
    """
    failed = {finding.failure.property: finding for finding in reversed(findings)}
    cases = [_case(name, prop, failed.get(prop), count) for prop, count in properties.items()]
    skipped = sum(count == 0 and prop not in failed for prop, count in properties.items())
    head = f'tests="{len(cases)}" failures="{len(failed)}" errors="0" skipped="{skipped}" time="{seconds:.3f}"'
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        f"<testsuites>\n<testsuite name={quoteattr(name)} {head}>\n{''.join(cases)}</testsuite>\n</testsuites>\n"
    )


def _case(name: str, prop: str, finding: Finding | None, exercised: int) -> str:
    head = f"<testcase classname={quoteattr(name)} name={quoteattr(prop)}"
    if finding is not None:
        story = escape(_printable("\n".join(story_of(finding))))
        return f"{head}>\n<failure message={quoteattr(_printable(finding.text))}>{story}</failure>\n</testcase>\n"
    if not exercised:
        return f'{head}>\n<skipped message="never exercised"/>\n</testcase>\n'
    return f"{head}/>\n"


def _printable(text: str) -> str:
    """Return a text without control characters, which XML does not allow."""
    return "".join(letter if letter.isprintable() or letter in "\n\t" else "?" for letter in text)


def page_of(check: Check, summary: Summary, folder: Path) -> str:
    """Return the report of a search as a self-contained page; *folder* has the results, as on a command line."""
    environment = templates(__package__)
    environment.filters |= {"count": "{:,}".format, "margin": _margin}
    body: str = environment.get_template("check.html").render(
        summary=summary,
        version=__version__,
        controller=_controller(check),
        shown=[_shown(each, summary.files.get(number, "")) for number, each in enumerate(summary.findings, 1)],
        folder=shlex.quote(str(folder)),
        tried=sorted(summary.tried.kinds),
        failed={each.failure.property for each in summary.findings},
        verdicts={verdict.property: verdict for verdict in summary.nominal.verdicts},
    )
    whole = Markup(body)  # noqa: S704 - escaped by the template
    return page_around(f"Check of {summary.name}", whole, style=part("check.css", __package__))


def _controller(check: Check) -> str:
    treatment = check.treatment
    command = treatment.command
    spec = treatment.tree or treatment.python or (command if isinstance(command, str) else shlex.join(command or ()))
    return str(spec)


def _shown(finding: Finding, file: str) -> dict[str, Any]:
    """Return a failure as the template shows it."""
    return {
        "finding": finding,
        "file": file,
        "injections": [(injection.describe(), passes(outcome)) for injection, outcome in finding.in_order],
        "lines": [{"at": at, "text": text, "mark": mark_of(text)} for at, text in events_of(finding.outcome)],
    }


def _margin(robustness: float) -> str:
    return f"{robustness:+.3g}" if math.isfinite(robustness) else "-"
