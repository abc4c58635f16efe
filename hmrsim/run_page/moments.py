"""The key moments of a run: those that show how it failed."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Collection, Iterator, Sequence
from typing import TYPE_CHECKING, Final, NamedTuple

from hmrsim.events.goals import GoalAccepted, GoalStatusChanged, SendGoalRejected
from hmrsim.events.traffic import GaveUpWaiting, LaneClosed
from hmrsim.protocol.goal import GoalStatus
from hmrsim.report.html import in_seconds
from hmrsim.run_page.omissions import ALSO, charge_at, goal_text, longest_pause, never_sent, robots_in

if TYPE_CHECKING:
    from hmrsim.run_page.comparison import Cause, Difference, ShownRun
    from hmrsim.run_page.run_log import Happening, Line, RunLog

_INSTANT: Final = 1e-6
"""Seconds within which two times are the same."""
_FAILED: Final = (GoalStatus.ABORTED, GoalStatus.CANCELED)
_IDLE: Final = "no robot executes a goal, and the controller sends none"
_ID: Final = re.compile(r"\b[0-9a-f]{32}\b")
"""The ids of goals, which distinguish nothing."""
_TIMES: Final = " times"
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
_MOST_MISSING: Final = 2
"""The maximum number of missing goals, and of robots with a long time without any."""
_MOST_GOALS: Final = 4
"""The maximum number of goals before the violation among the key moments."""


class Moment(NamedTuple):
    """A moment of a run that may tell why it failed.

    Attributes:
        at: Seconds since the run began.
        kind: One of `_ORDER`.
        text: A description of what happened.
        beside: The same for the other run; empty if that is not known.
        seen: The number of lines up to its event, if it has one.
        violation: The index of the violation, if it is one.
    """

    at: float
    kind: str
    text: str
    beside: str = ""
    seen: int | None = None
    violation: int | None = None


_ORDER: Final = ("cause", "goal", "difference", "missing", "alarm", "silent", "still", "violated", "end")


def moments_of(
    causes: Sequence[Cause], failing: ShownRun, other: ShownRun | None, difference: Difference | None
) -> list[Moment]:
    """Return the key moments of a run, in order of time."""
    log, violations = failing.log, failing.violations
    until = violations[0][0] if violations else failing.at
    found = [*_begins(causes, log), *_missing(robots_in([failing.failure], log), failing, other, until)]
    if difference is not None:
        found.append(Moment(difference.at, "difference", *difference.texts, difference.seen[0]))
    differs = None if difference is None else difference.seen[0]
    alarms = _alarms(log, () if other is None else other.log.lines)
    found += [alarm for alarm in alarms if alarm.seen != differs or _TIMES in alarm.text][:_MOST_GRAVE]
    if failing.at - log.quiet_from > max(_QUIET, failing.at * _QUIET_SHARE):
        still = [*log.stuck, *log.awaited()][:_MOST_STILL] or [_IDLE]
        found.append(Moment(log.quiet_from, "still", "; ".join(still)))
    silent = [*_silent(failing, other, difference)] if other is not None and difference is not None else []
    found += silent[:_MOST_STILL] or _gave_up(log)
    found += _last_goals(log, until, {each.seen for each in found})
    found += [Moment(at, "violated", text, violation=i) for i, (at, text) in enumerate(violations[:_MOST_VIOLATED])]
    if more := violations[_MOST_VIOLATED:]:
        text = f"{len(more)} more, which are among the events"
        found.append(Moment(more[0][0], "violated", text, violation=_MOST_VIOLATED))
    found.append(Moment(failing.at, "end", f"the run {failing.ending}"))
    # Stamps of time 0 are those of the first nanosecond.
    return sorted(found, key=_place)


def _place(moment: Moment) -> tuple[float, float, int]:
    """Return the place of a moment among others: by time, by its event, and by its kind."""
    within = math.inf if moment.seen is None and moment.kind != "cause" else moment.seen or 0
    return round(moment.at, 6), within, _ORDER.index(moment.kind)


def _begins(causes: Sequence[Cause], log: RunLog) -> Iterator[Moment]:
    """Yield the moments at which faults and disturbances begin."""
    faults = [*log.faults]
    for cause in causes:
        if cause.began is not None:
            own = next((fault for fault in faults if abs(fault[0] - cause.began) < _INSTANT), None)
            if own is not None:
                faults.remove(own)
            yield Moment(cause.began, "cause", cause.text, seen=None if own is None else own[1] + 1)


def _missing(robots: Sequence[str], failing: ShownRun, other: ShownRun | None, until: float) -> Iterator[Moment]:
    """Yield what robots lack in the run that fails: kinds of goals, and for a long time any goal."""
    if other is not None:
        for at, text in [*never_sent(failing.log, other.log, failing.at)][:_MOST_MISSING]:
            yield Moment(at, "missing", f"{other.title}: {text}")
    for robot in robots[:_MOST_MISSING]:
        began, ended = longest_pause(robot, failing.log, until)
        if ended - began > max(_QUIET, until * _QUIET_SHARE):
            both = other is not None and longest_pause(robot, other.log, until) == (began, ended)
            text = f"{robot} gets no goal until {ended:.3f} s{ALSO if both else ''}"
            yield Moment(began, "missing", text)


def _last_goals(log: RunLog, until: float, known: Collection[int | None]) -> Iterator[Moment]:
    """Yield the last goals before a time with their ends, other than those whose end is a known moment."""
    sent: dict[str, tuple[Happening, GoalAccepted]] = {}
    ends: dict[str, tuple[Happening, GoalStatusChanged]] = {}
    for each in log.happenings:
        if each.told and isinstance(each.event, GoalAccepted) and in_seconds(each.at) < until + _INSTANT:
            sent[each.event.goal_id] = each, each.event
        elif each.told and isinstance(each.event, GoalStatusChanged):
            ends[each.event.goal_id] = each, each.event
    for goal_id, (goal, event) in [*sent.items()][-_MOST_GOALS:]:
        line, ended = log.lines[goal.line], "does not end"
        if goal_id in ends:
            end, status = ends[goal_id]
            if end.line + 1 in known:
                continue
            ended = f"{GoalStatus(status.status).name} at {in_seconds(end.at):.3f} s"
        what = f"{goal_text(log, event)}{charge_at(log, event.robot, goal.at)}"
        yield Moment(line.at, "goal", f"{what}, {ended}", seen=goal.line + 1)


def _gave_up(log: RunLog) -> list[Moment]:
    """Return the failure of a goal after which the controller sends no goal at all, if there is one."""
    found: list[Moment] = []
    for each in log.happenings:
        event, how = each.event, ""
        if isinstance(event, GoalAccepted):
            found = []
        elif isinstance(event, SendGoalRejected):
            how = "was rejected"
        elif isinstance(event, GoalStatusChanged) and GoalStatus(event.status) in _FAILED:
            how = f"ended as {GoalStatus(event.status).name}"
        if how and isinstance(event, SendGoalRejected | GoalStatusChanged):
            text = f"after {event.action} of {event.robot} {how}, the controller sends no further goal"
            found = [Moment(in_seconds(each.at), "silent", text, seen=each.line + each.told)]
    return found


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


def _alarms(log: RunLog, others: Sequence[Line]) -> list[Moment]:
    """Return the first warning and error of each text that the other run has not had by then, with their number."""
    had: dict[tuple[str, str], float] = {}
    for line in others:
        had.setdefault((line.subject, _ID.sub("", line.text)), line.at)
    closed: set[tuple[float, frozenset[str]]] = set()
    found: dict[tuple[str, str], list[Moment]] = {}
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
        if key in found or key not in had or had[key] > line.at:
            text = f"{line.subject} {line.text}".lstrip()
            found.setdefault(key, []).append(Moment(line.at, "alarm", text, seen=happening.line + 1))
    return [_repeated(alarms) for alarms in found.values()]


def _repeated(alarms: Sequence[Moment]) -> Moment:
    """Return the first of some alarms with the same text, with their number."""
    first, last = alarms[0], alarms[-1]
    if first is last:
        return first
    until = "" if last.at - first.at < _INSTANT else f" until {last.at:.3f} s"
    return first._replace(text=f"{first.text}, {len(alarms)}{_TIMES}{until}")
