"""The key moments of a run: those that show how it failed."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Final, NamedTuple

from hmrsim.events.goals import GoalAccepted, GoalStatusChanged, SendGoalRejected
from hmrsim.events.robots import BatteryEvent
from hmrsim.events.traffic import GaveUpWaiting, LaneClosed
from hmrsim.protocol.goal import GoalStatus
from hmrsim.report.goals import error_in
from hmrsim.report.html import in_seconds
from hmrsim.run_page.omissions import ALSO, charge_at, goal_text, longest_pause, never_sent, robots_in

if TYPE_CHECKING:
    from hmrsim.run_page.comparison import Cause, Difference, ShownRun
    from hmrsim.run_page.run_log import RunLog

_INSTANT: Final = 1e-6
"""Seconds within which two times are the same."""
_FAILED: Final = (GoalStatus.ABORTED, GoalStatus.CANCELED)
_IDLE: Final = "no robot executes a goal, and the controller sends none"
_ID: Final = re.compile(r"\b[0-9a-f]{32}\b")
"""The ids of goals, which distinguish nothing."""
_LATER: Final = " (later in the passing run, too)"
_STUCK: Final = 5
"""The minimum number of times that the alarm occurs at which a run is stuck."""
_GRAVE: Final = ("warning", "error")
_MOST_GRAVE: Final = 8
"""The maximum number of warnings among the key moments."""
_MOST_VIOLATED: Final = 5
"""The maximum number of violated properties among the key moments."""
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


_ORDER: Final = ("cause", "goal", "difference", "missing", "alarm", "stuck", "silent", "still", "violated", "end")


def moments_of(
    causes: Sequence[Cause], failing: ShownRun, other: ShownRun | None, difference: Difference | None
) -> list[Moment]:
    """Return the key moments of a run, in order of time."""
    log, violations = failing.log, failing.violations
    until = violations[0][0] if violations else failing.at
    found = [*_begins(causes, log), *_missing(robots_in([failing.failure], log), failing, other, until)]
    if difference is not None:
        found.append(Moment(difference.at, "difference", *difference.texts, difference.seen[0]))
    robots = robots_in([failing.failure, *(cause.text for cause in causes)], log)
    alarms = _alarms(log, robots, other, until)
    differs = None if difference is None else difference.seen[0]
    found += [*_repeated(each for each in alarms if each[0].seen != differs or len(each) > 1)]
    if failing.at - log.quiet_from > max(_QUIET, failing.at * _QUIET_SHARE):
        still = [*log.stuck, *log.awaited()][:_MOST_STILL] or [_IDLE]
        found.append(Moment(log.quiet_from, "still", "; ".join(still)))
    silent = [*_silent(failing, other, difference)] if other is not None and difference is not None else []
    found += silent[:_MOST_STILL] or _gave_up(failing)
    known = {each.seen for each in found}.union(each.seen for repeated in alarms for each in repeated)
    found += [*_last_goals(failing, other, robots, known), *_violated(violations)]
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


def _violated(violations: Sequence[tuple[float, str]]) -> Iterator[Moment]:
    """Yield the first violation of each property, with the number of the others."""
    of: dict[str, list[int]] = {}
    for i, (_, text) in enumerate(violations):
        of.setdefault(text.partition(":")[0], []).append(i)
    for first, *more in [*of.values()][:_MOST_VIOLATED]:
        at, text = violations[first]
        also = f"; {len(more)} more until {violations[more[-1]][0]:.3f} s" if more else ""
        yield Moment(at, "violated", f"{text}{also}", violation=first)


class _Goal(NamedTuple):
    """A goal with its end.

    Attributes:
        at: When it was accepted, in nanoseconds.
        seen: The number of lines up to that.
        end: The number of lines up to its end, if it ends.
    """

    at: int
    seen: int
    end: int | None
    robot: str
    text: str
    ended: str


def _goals(log: RunLog, until: float) -> list[_Goal]:
    """Return the goals that are accepted until a time, in order."""
    sent: dict[str, _Goal] = {}
    for each in log.happenings:
        event = each.event
        if each.told and isinstance(event, GoalAccepted) and in_seconds(each.at) < until + _INSTANT:
            text = goal_text(log, event)
            sent[event.goal_id] = _Goal(each.at, each.line + 1, None, event.robot, text, "does not end")
        elif each.told and isinstance(event, GoalStatusChanged) and event.goal_id in sent:
            ended = f"{GoalStatus(event.status).name} at {in_seconds(each.at):.3f} s"
            sent[event.goal_id] = sent[event.goal_id]._replace(end=each.line + 1, ended=ended)
    return [*sent.values()]


def _last_goals(
    failing: ShownRun, other: ShownRun | None, robots: Sequence[str], known: Collection[int | None]
) -> Iterator[Moment]:
    """Yield the last goals of some robots, or of all if there are none, other than those whose end is a known moment.

    A goal that has been sent before is shown once.
    """
    until = failing.violations[0][0] if failing.violations else failing.at
    beside = set() if other is None else {(each.at, each.text, each.ended) for each in _goals(other.log, until)}
    last: dict[str, list[_Goal]] = {}
    for goal in reversed(_goals(failing.log, until)):
        if (not robots or goal.robot in robots) and (goal.end is None or goal.end not in known):
            last.setdefault(goal.text, []).append(goal)
    for goal, *before in [*last.values()][:_MOST_GOALS]:
        times = f", as {'once' if len(before) == 1 else f'{len(before)} times'} before" if before else ""
        also = ALSO if (goal.at, goal.text, goal.ended) in beside else ""
        yield Moment(
            round(in_seconds(goal.at), 6),
            "goal",
            f"{goal.text}{charge_at(failing.log, goal.robot, goal.at)}, {goal.ended}{times}{also}",
            seen=goal.seen,
        )


def _gave_up(run: ShownRun) -> list[Moment]:
    """Return the failure of a goal after which the controller sends no goal at all, if there is one."""
    found: list[Moment] = []
    for each in run.log.happenings:
        event, how = each.event, ""
        if isinstance(event, GoalAccepted):
            found = []
        elif isinstance(event, SendGoalRejected):
            how = f"was rejected (reason {event.reason})"
        elif isinstance(event, GoalStatusChanged) and GoalStatus(event.status) in _FAILED:
            code, _ = error_in(event.result)
            why = [f"cause {event.cause}"] * bool(event.cause) + [f"error code {code}"] * bool(code)
            how = f"ended as {GoalStatus(event.status).name}" + (f" ({', '.join(why)})" if why else "")
        if how and isinstance(event, SendGoalRejected | GoalStatusChanged):
            text = f"after {event.action} of {event.robot} {how}, the controller sends no further goal"
            found = [Moment(in_seconds(each.at), "silent", text, seen=each.line + each.told)]
    # A run that is stopped may have been between two attempts.
    return [each for each in found if not run.stopped or run.at - each.at > max(_QUIET, run.at * _QUIET_SHARE)]


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


def _alarms(log: RunLog, robots: Sequence[str], other: ShownRun | None, until: float) -> list[list[Moment]]:
    """Return the warnings and errors of each text, unless the other run has had it by then.

    The levels of batteries are those of some robots, if any, until a time.
    """
    had: dict[tuple[str, str], float] = {}
    for line in () if other is None else other.log.lines:
        had.setdefault((line.subject, _ID.sub("", line.text)), line.at)
    closed: set[tuple[float, frozenset[str]]] = set()
    found: dict[tuple[str, str], list[Moment]] = {}
    for happening in log.happenings:
        event = happening.event
        if not happening.told or isinstance(event, GaveUpWaiting):
            # The end of the goal says why its robot gave up.
            continue
        line = log.lines[happening.line]
        if line.severity not in _GRAVE or line.at > log.quiet_from:
            continue
        if isinstance(event, BatteryEvent) and (line.at > until or (robots and event.robot not in robots)):
            continue
        if isinstance(event, LaneClosed):
            lane = line.at, frozenset(event.lane)
            if lane in closed:
                continue
            closed.add(lane)
        key = line.subject, _ID.sub("", line.text)
        if key in found or key not in had or had[key] > line.at:
            also = _LATER if key in had else ""
            text = f"{line.subject} {line.text}{also}".lstrip()
            found.setdefault(key, []).append(Moment(line.at, "alarm", text, seen=happening.line + 1))
    return [*found.values()]


def _repeated(alarms: Iterable[Sequence[Moment]]) -> Iterator[Moment]:
    """Yield the first of the alarms with the same text, with their number.

    The run is stuck at the one that occurs most often.
    """
    shown = [*alarms][:_MOST_GRAVE]
    most = max([len(each) for each in shown], default=0)
    for each in shown:
        first, last = each[0], each[-1]
        if first is last:
            yield first
            continue
        until = "" if last.at - first.at < _INSTANT else f" until {last.at:.3f} s"
        kind = "stuck" if len(each) == most >= _STUCK else first.kind
        yield first._replace(kind=kind, text=f"{first.text}, {len(each)} times{until}")
