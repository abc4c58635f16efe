"""Where two runs first differ, and the moments that tell how a run failed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import zip_longest
from typing import TYPE_CHECKING, Final, NamedTuple

from hmrsim.report.html import in_seconds

if TYPE_CHECKING:
    from hmrsim.run_page.run_log import Happening, Line, RunLog

_ENDS: Final = "no further event"
_GRAVE: Final = ("warning", "error")
_MOST_GRAVE: Final = 8
"""The maximum number of warnings among the key moments."""


@dataclass(frozen=True)
class Cause:
    """A fault or disturbance with which a run fails.

    Attributes:
        text: It in words.
        began: When it began, in seconds since the run began; None if it never did.
        without: How the run ends without it, in words; empty if that is not known.
    """

    text: str
    began: float | None
    without: str = ""


@dataclass(frozen=True)
class ShownRun:
    """A run on a page.

    Attributes:
        title: What it is, such as "without the fault".
        log: Its log.
        ending: How it ended, in words.
        at: When it ended, in seconds since it began.
        violations: The violated properties in words, each with its time in seconds.
    """

    title: str
    log: RunLog
    ending: str
    at: float
    violations: Sequence[tuple[float, str]] = ()


class Difference(NamedTuple):
    """The first event in which two runs differ, other than faults.

    Attributes:
        at: Seconds since the runs began.
        lines: The number of lines before it, in each run.
        texts: The event in each run, in words.
    """

    at: float
    lines: tuple[int, int]
    texts: tuple[str, str]


def first_difference(one: RunLog, other: RunLog) -> Difference | None:
    """Return where two runs first differ, apart from the faults themselves; None if they don't."""
    for a, b in zip_longest(one.happenings, other.happenings):
        if a is None or b is None or a[:2] != b[:2]:
            at = min(each.at for each in (a, b) if each is not None)
            lines = (len(one.lines) if a is None else a.line, len(other.lines) if b is None else b.line)
            return Difference(in_seconds(at), lines, (_text(one, a), _text(other, b)))
    return None


def _text(log: RunLog, happening: Happening | None) -> str:
    if happening is None:
        return _ENDS
    return f"{in_seconds(happening.at):.3f} s: {log.describe(happening.event)}"


class Moment(NamedTuple):
    """A moment of a run that may tell why it failed.

    Attributes:
        at: Seconds since the run began.
        kind: ``cause``, ``difference``, ``alarm``, ``violated`` or ``end``.
        text: What happened.
        beside: What happened in the other run instead; empty if that is not known.
        line: The line of the event, if it is one.
    """

    at: float
    kind: str
    text: str
    beside: str = ""
    line: int | None = None


_ORDER: Final = ("cause", "difference", "alarm", "violated", "end")


def moments_of(
    causes: Sequence[Cause], failing: ShownRun, other: ShownRun | None, difference: Difference | None
) -> list[Moment]:
    """Return the key moments of a run, in order of time."""
    found = [Moment(cause.began, "cause", cause.text) for cause in causes if cause.began is not None]
    if difference is not None:
        found.append(Moment(difference.at, "difference", *difference.texts, difference.lines[0]))
    known = set() if other is None else {(line.subject, line.text) for line in other.log.lines}
    differs = None if difference is None else difference.lines[0]
    found += [alarm for alarm in _alarms(failing.log.lines, known) if alarm.line != differs][:_MOST_GRAVE]
    found += [Moment(at, "violated", text) for at, text in failing.violations]
    found.append(Moment(failing.at, "end", f"the run {failing.ending}"))
    return sorted(found, key=lambda moment: (moment.at, _ORDER.index(moment.kind)))


def _alarms(lines: Sequence[Line], known: set[tuple[str, str]]) -> Iterator[Moment]:
    """Yield the first warning and error of each text that the other run does not have."""
    seen = set(known)
    for i, line in enumerate(lines):
        if line.severity in _GRAVE and (line.subject, line.text) not in seen and " the fault " not in line.text:
            seen.add((line.subject, line.text))
            yield Moment(line.at, "alarm", f"{line.subject} {line.text}".lstrip(), line=i)
