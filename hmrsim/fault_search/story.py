"""The story of a failure in plain words: its injections, the events of the robots, and the violation."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Final

from hmrsim.fault_search.observer import DISTURBED
from hmrsim.fault_search.run import NOT_RUN

if TYPE_CHECKING:
    from hmrsim.fault_search.run import Outcome
    from hmrsim.fault_search.summary import Finding

SHORT: Final = 60
"""The maximum number of events in a story among others, such as on a page."""
LONG: Final = 1000
"""The maximum number of events in a story in a separate file, or on request."""
_VIOLATED: Final = "VIOLATED"
_WORD: Final = re.compile(r"\w+")
_RARE: Final = 0.25
"""A word that occurs in a larger share of the events does not identify the subject of a failure."""
_NUMBER: Final = re.compile(r"\b(?:[0-9a-f]{8,}|\d+(?:\.\d+)?)\b")
_MAX_BLOCK: Final = 4
"""The longest sequence of events that is shown once if it repeats."""
_FOLDED: Final = 4
"""The minimum number of repetitions that are folded."""
_TAIL: Final = 20
"""The number of events before the violation that are always shown."""


def story_of(finding: Finding, most: int = SHORT) -> list[str]:
    """Return the lines of a story: the failure, the schedule, the outcome without each injection, and the events.

    It has at most *most* events.
    """
    lines = [f"{finding.failure.property}: {finding.text}", "", *_schedule(finding), ""]
    lines += [f"{at:10.3f} s  {text}" for at, text in events_of(finding.outcome, most)]
    cause = f" ({finding.outcome.cause})" if finding.outcome.cause else ""
    lines.append(f"{finding.outcome.at:10.3f} s  the run ends: {finding.outcome.ending}{cause}")
    return lines


def _schedule(finding: Finding) -> Iterator[str]:
    if not finding.schedule:
        yield "It fails without any fault."
        return
    yield "It fails with" + (":" if len(finding.schedule) > 1 else " one thing:")
    for number, (injection, _) in enumerate(finding.in_order, 1):
        yield f"  {number}. {injection.describe()}"
    for number, (_, outcome) in enumerate(finding.in_order, 1):
        which = f"thing {number}" if len(finding.schedule) > 1 else "it"
        yield f"Without {which} {passes(outcome)}."


def passes(outcome: Outcome) -> str:
    """Return the outcome of a run in words: it passes, or fails for another reason."""
    if outcome.ending == NOT_RUN:
        return "it is not known what comes of it: there was no time to try"
    if outcome.failure is None:
        return f"it passes: the run ends as {outcome.ending} at {outcome.at:.1f} s"
    return f"it fails otherwise: {outcome.failure}"


def events_of(outcome: Outcome, most: int = SHORT) -> list[tuple[float, str]]:
    """Return the events with the violations among them; if there are many, those around faults and violations."""
    marks = [(each.at / 1e9, f"{_VIOLATED} {each.property}: {each.text}") for each in outcome.violations]
    lines = _folded(sorted([*outcome.story, *marks], key=lambda line: line[0]))
    return lines if len(lines) <= most else _cut(lines, most)


def mark_of(text: str) -> str:
    """Return the mark of an event: ``violated``, ``thing`` for an injection, or empty."""
    if text.startswith(_VIOLATED):
        return "violated"
    return "thing" if " fault " in text or text.startswith(DISTURBED) else ""


def _folded(lines: Sequence[tuple[float, str]]) -> list[tuple[float, str]]:
    """Return the lines with each repeated sequence of up to four lines shown once, with its count."""
    plain = [_NUMBER.sub("", text) for _, text in lines]
    found: list[tuple[float, str]] = []
    i = 0
    while i < len(lines):
        blocks = [(size, _repeats(plain, i, size)) for size in range(1, _MAX_BLOCK + 1)]
        size, times = next(((size, times) for size, times in blocks if times >= _FOLDED), (1, 1))
        found += lines[i : i + size]
        i += size * times
        if times > 1:
            what = "this" if size == 1 else f"these {size} events"
            found.append((lines[i - 1][0], f"… {what} {times - 1} times more, up to here …"))
    return found


def _repeats(texts: Sequence[str], start: int, size: int) -> int:
    """Return the number of times that a block of texts occurs in a row."""
    block, times = texts[start : start + size], 1
    while texts[start + size * times : start + size * (times + 1)] == block and len(block) == size:
        times += 1
    return times


def _cut(lines: Sequence[tuple[float, str]], most: int) -> list[tuple[float, str]]:
    """Return at most *most* lines, with the number of lines left out between them.

    Lines at the end and around faults and violations have priority, then those with a robot, an order, an item or
    another word of faults and violations, the latest first.
    """
    texts = [text for _, text in lines]
    marked = [i for i, text in enumerate(texts) if mark_of(text)]
    wanted = dict.fromkeys(range(max(0, len(lines) - _TAIL), len(lines)))
    for i in marked:
        wanted |= dict.fromkeys(range(max(0, i - 3), min(len(lines), i + 6)))
    words = [{*_WORD.findall(text)} for text in texts]
    # A word in every line distinguishes nothing.
    counts = Counter(word for each in words for word in each)
    names = {word for i in marked for word in words[i] if counts[word] <= len(texts) * _RARE}
    wanted |= dict.fromkeys(i for i in reversed(range(len(lines))) if names & words[i])
    found: list[tuple[float, str]] = []
    before = -1
    for i in sorted([*wanted][:most]):
        if i > before + 1:
            found.append((lines[i][0], f"… {i - before - 1} events …"))
        found.append(lines[i])
        before = i
    return found
