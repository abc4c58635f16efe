"""JUnit XML, as continuous integration reads it: a test case for each property."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING
from xml.sax.saxutils import escape, quoteattr

from hmrsim.fault_search.results.story import story_of

if TYPE_CHECKING:
    from hmrsim.fault_search.results.finding import Finding


def junit_text(name: str, properties: Mapping[str, int], findings: Sequence[Finding], seconds: float) -> str:
    """Return the document.

    Args:
        name: The name of the check.
        properties: How often each property was exercised, by name.
        findings: What was found.
        seconds: Wall seconds that the search took.
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
    """Return a text without the control characters that XML can't have."""
    return "".join(letter if letter.isprintable() or letter in "\n\t" else "?" for letter in text)
