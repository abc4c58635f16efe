"""Comparison of two runs: their first difference, and the moments that show how a run failed."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import zip_longest
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from hmrsim.events.goals import GoalAccepted, GoalStatusChanged, SendGoalRejected
from hmrsim.events.robots import MotionBegan
from hmrsim.events.traffic import GaveUpWaiting, LaneClosed, LaneEvent
from hmrsim.report.html import in_seconds

if TYPE_CHECKING:
    from hmrsim.run_page.run_log import Happening, Line, RunLog

_ENDS: Final = "no further event"
_IDLE: Final = "no robot executes a goal, and the controller sends none"
_ID: Final = re.compile(r"\b[0-9a-f]{32}\b")
"""The ids of goals, which distinguish nothing."""
_GRAVE: Final = ("warning", "error")
_MOST_GRAVE: Final = 8
"""The maximum number of warnings among the key moments."""
_MOST_VIOLATED: Final = 5
"""The maximum number of violations among the key moments."""
_QUIET: Final = 5.0
"""Seconds without an event after which a run that goes on stands still."""
_QUIET_SHARE: Final = 0.2
"""The share of a run that such a time has to be."""
_MOST_STILL: Final = 4
"""The maximum number of reasons why it does."""


@dataclass(frozen=True)
class Heading:
    """The texts at the top of a page.

    Attributes:
        kind: The kind of page.
        title: The title, such as the name of the property that is violated.
        text: The line below it; may be empty.
        alone: The cause of the failure if no fault causes it.
        note: A remark about the world of the run; may be empty.
    """

    kind: str
    title: str
    text: str
    alone: str
    note: str = ""


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
        title: A description, such as "without the fault".
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
    """The first event in which two runs differ, other than faults and controllers that come and go.

    Attributes:
        at: Seconds since the runs began.
        lines: The number of lines before it, in each run.
        seen: The same, with the event if it is a line.
        texts: The event in each run, in words.
    """

    at: float
    lines: tuple[int, int]
    seen: tuple[int, int]
    texts: tuple[str, str]


def first_difference(one: RunLog, other: RunLog) -> Difference | None:
    """Return where two runs first differ, apart from faults and the lanes that they close; None if they don't."""
    events = ([each for each in log.happenings if not isinstance(each.event, LaneEvent)] for log in (one, other))
    for a, b in zip_longest(*events):
        if a is None or b is None or _key(a) != _key(b):
            at = min(each.at for each in (a, b) if each is not None)
            sides = [_side(log, each, at) for log, each in ((one, a), (other, b))]
            (first, first_seen, text), (second, second_seen, beside) = sides
            return Difference(in_seconds(at), (first, second), (first_seen, second_seen), (text, beside))
    return None


def _key(happening: Happening) -> tuple[Any, ...]:
    """Return what has to be equal; ids of goals depend on the name of the controller."""
    event = happening.event
    fields = zip(event._fields, event, strict=True)
    return happening.at, type(event), *(value for name, value in fields if name != "goal_id")


def _side(log: RunLog, happening: Happening | None, at: int) -> tuple[int, int, str]:
    """Return the lines before an event that differs, those with it at the time of the difference, and its text."""
    if happening is None:
        return len(log.lines), len(log.lines), _ENDS
    text, event, starts = log.describe(happening.event), happening.event, in_seconds(happening.at)
    if isinstance(event, MotionBegan):
        text = f"{text} from {starts:.3f} to {starts + event.duration:.3f} s"
    elif happening.at > at:
        text = f"{text}, at {starts:.3f} s"
    return happening.line, happening.line + (happening.told and happening.at == at), text


class Moment(NamedTuple):
    """A moment of a run that may tell why it failed.

    Attributes:
        at: Seconds since the run began.
        kind: ``cause``, ``difference``, ``alarm``, ``silent``, ``still``, ``violated`` or ``end``.
        text: A description of what happened.
        beside: The same for the other run; empty if that is not known.
        seen: The number of lines up to its event, if it has one.
    """

    at: float
    kind: str
    text: str
    beside: str = ""
    seen: int | None = None


_ORDER: Final = ("cause", "difference", "alarm", "silent", "still", "violated", "end")


def moments_of(
    causes: Sequence[Cause], failing: ShownRun, other: ShownRun | None, difference: Difference | None
) -> list[Moment]:
    """Return the key moments of a run, in order of time."""
    log = failing.log
    found = [Moment(cause.began, "cause", cause.text) for cause in causes if cause.began is not None]
    if difference is not None:
        found.append(Moment(difference.at, "difference", *difference.texts, difference.seen[0]))
    differs = None if difference is None else difference.seen[0]
    alarms = _alarms(log, () if other is None else other.log.lines)
    found += [alarm for alarm in alarms if alarm.seen != differs][:_MOST_GRAVE]
    if failing.at - log.quiet_from > max(_QUIET, failing.at * _QUIET_SHARE):
        still = [*log.stuck, *log.awaited()][:_MOST_STILL] or [_IDLE]
        found.append(Moment(log.quiet_from, "still", "; ".join(still)))
    if other is not None and difference is not None:
        found += [*_silent(failing, other, difference)][:_MOST_STILL]
    found += [Moment(at, "violated", text) for at, text in failing.violations[:_MOST_VIOLATED]]
    if more := failing.violations[_MOST_VIOLATED:]:
        found.append(Moment(more[0][0], "violated", f"{len(more)} more, which are among the events"))
    found.append(Moment(failing.at, "end", f"the run {failing.ending}"))
    # Stamps of time 0 are those of the first nanosecond.
    return sorted(found, key=lambda moment: (round(moment.at, 6), _ORDER.index(moment.kind)))


def _silent(failing: ShownRun, other: ShownRun, difference: Difference) -> Iterator[Moment]:
    """Yield the robots that get no goal after some time, although they get more in the other run."""
    last: dict[str, int] = {}
    for happening in failing.log.happenings:
        if isinstance(happening.event, (GoalAccepted, GoalStatusChanged, SendGoalRejected)):
            last[happening.event.robot] = happening.at
    got, beside = (_goals_from(run.log, difference.at) for run in (failing, other))
    for robot, at in last.items():
        since, more = in_seconds(at), beside[robot] - got[robot]
        if more > 0 and failing.at - since > max(_QUIET, failing.at * _QUIET_SHARE):
            yield Moment(since, "silent", f"{robot} gets no further goal; in the other run it gets {more} more")


def _goals_from(log: RunLog, at: float) -> Counter[str]:
    """Return how many goals each robot gets from some time on."""
    events = (each.event for each in log.happenings if in_seconds(each.at) >= at)
    return Counter(event.robot for event in events if isinstance(event, GoalAccepted))


def _alarms(log: RunLog, others: Sequence[Line]) -> Iterator[Moment]:
    """Yield the first warning and error of each text that the other run has not had by then."""
    had: dict[tuple[str, str], float] = {}
    for line in others:
        had.setdefault((line.subject, _ID.sub("", line.text)), line.at)
    closed: set[tuple[float, frozenset[str]]] = set()
    for happening in log.happenings:
        if not happening.told or isinstance(happening.event, GaveUpWaiting):
            # The end of the goal says why its robot gave up.
            continue
        line = log.lines[happening.line]
        if line.severity not in _GRAVE or line.at > log.quiet_from:
            continue
        if isinstance(happening.event, LaneClosed):
            lane = line.at, frozenset(happening.event.lane)
            if lane in closed:
                continue
            closed.add(lane)
        key = line.subject, _ID.sub("", line.text)
        if key not in had or had[key] > line.at:
            had[key] = line.at
            yield Moment(line.at, "alarm", f"{line.subject} {line.text}".lstrip(), seen=happening.line + 1)
