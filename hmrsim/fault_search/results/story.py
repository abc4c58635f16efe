"""The story of a failure in plain words: what went wrong, what the robots did, what does not hold."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from hmrsim.fault_search.results.finding import Finding
    from hmrsim.fault_search.running.outcome import Outcome

_MAX_LINES: Final = 60
_TAIL: Final = 20
"""Events before the violation that are told in any case."""


def story_of(finding: Finding) -> list[str]:
    """Return the story, a line each: the failure, the schedule, what is without each thing of it, and the events."""
    lines = [f"{finding.failure.property}: {finding.text}", "", *_schedule(finding), ""]
    lines += [f"{at:10.3f} s  {text}" for at, text in events_of(finding.told)]
    cause = f" ({finding.told.cause})" if finding.told.cause else ""
    lines.append(f"{finding.told.at:10.3f} s  the run ends: {finding.told.ending}{cause}")
    return lines


def _schedule(finding: Finding) -> Iterator[str]:
    if not finding.schedule:
        yield "It fails without any fault."
        return
    yield "It fails with" + (":" if len(finding.schedule) > 1 else " one thing:")
    for number, thing in enumerate(finding.schedule, 1):
        yield f"  {number}. {thing.describe()}"
    for number, outcome in enumerate(finding.without, 1):
        which = f"thing {number}" if len(finding.schedule) > 1 else "it"
        yield f"Without {which} {passes(outcome)}."


def passes(outcome: Outcome) -> str:
    """Return in words what came of a run: that it passes, or how else it fails."""
    if outcome.failure is None:
        return f"it passes: the run ends as {outcome.ending} at {outcome.at:.1f} s"
    return f"it fails otherwise: {outcome.failure}"


def events_of(outcome: Outcome) -> list[tuple[float, str]]:
    """Return the events up to the end, with the violations among them; of many, the ones around what went wrong."""
    marks = [(each.at / 1e9, f"VIOLATED {each.property}: {each.text}") for each in outcome.violations]
    lines = sorted([*outcome.story, *marks], key=lambda line: line[0])
    if len(lines) <= _MAX_LINES:
        return lines
    return _cut(lines)


def _cut(lines: Sequence[tuple[float, str]]) -> list[tuple[float, str]]:
    """Return the lines around faults and violations, and say how many are left out between them."""
    wanted = dict.fromkeys(range(max(0, len(lines) - _TAIL), len(lines)))
    for i, (_, text) in enumerate(lines):
        if "fault" in text or text.startswith("VIOLATED"):
            wanted |= dict.fromkeys(range(max(0, i - 3), min(len(lines), i + 6)))
    found: list[tuple[float, str]] = []
    before = -1
    for i in sorted(wanted)[-_MAX_LINES:]:
        if i > before + 1:
            found.append((lines[i][0], f"… {i - before - 1} events …"))
        found.append(lines[i])
        before = i
    return found
