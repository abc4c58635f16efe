"""Comparison of two runs: the texts at the top of their page, and their first difference."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import zip_longest
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from hmrsim.events.robots import BatteryEvent, MotionBegan
from hmrsim.events.traffic import LaneEvent
from hmrsim.report.html import in_seconds

if TYPE_CHECKING:
    from hmrsim.events import Event
    from hmrsim.run_page.run_log import Happening, RunLog

_ENDS: Final = "no further event"


@dataclass(frozen=True)
class Heading:
    """The texts at the top of a page.

    Attributes:
        kind: The kind of page, such as the property that is violated.
        title: The title, such as what happened.
        text: The line below it; may be empty.
        alone: Why there is no other run, or what the runs have in common.
        note: A remark about the world of the run; may be empty.
        code: Lines of the controller that the text names, each with its place.
    """

    kind: str
    title: str
    text: str
    alone: str
    note: str = ""
    code: Sequence[tuple[str, str]] = ()


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
        failure: The failure in words; empty if there is none.
        stopped: Whether it was stopped before its controller ended.
    """

    title: str
    log: RunLog
    ending: str
    at: float
    violations: Sequence[tuple[float, str]] = ()
    failure: str = ""
    stopped: bool = False


class Difference(NamedTuple):
    """The first event in which two runs differ, other than faults and controllers that come and go.

    Attributes:
        at: Seconds since the runs began.
        lines: The number of lines before it, in each run.
        seen: The same, with the event if it is a line.
        texts: The event in one run, and what the other one does instead, in words.
    """

    at: float
    lines: tuple[int, int]
    seen: tuple[int, int]
    texts: tuple[str, str]


def first_difference(one: RunLog, other: RunLog) -> Difference | None:
    """Return where two runs first differ, apart from faults and the lanes that they close; None if they don't."""
    events = [[each for each in log.happenings if not is_left_out(each.event)] for log in (one, other)]
    for i, (a, b) in enumerate(zip_longest(*events)):
        if a is None or b is None or _key(a) != _key(b):
            at = min(each.at for each in (a, b) if each is not None)
            (first, first_seen, text), (second, second_seen, beside) = _side(one, a, at), _side(other, b, at)
            if a is not None and b is not None and a.event.subject != b.event.subject:
                own, its = (
                    _about(log, rest[i:], a if a.at == at else b, at)
                    for log, rest in zip((one, other), events, strict=True)
                )
                text, beside = (own, its) if own != its else (text, beside)
            return Difference(in_seconds(at), (first, second), (first_seen, second_seen), (text, beside))
    return None


def _about(log: RunLog, events: Sequence[Happening], differs: Happening, at: int) -> str:
    """Return in words what a run does instead of an event of another one: its next event of the same subject."""
    subject = differs.event.subject
    happening = next((each for each in events if each.event.subject == subject), None)
    if isinstance(differs.event, BatteryEvent) and happening is not differs:
        shares = [share for since, share in log.report().batteries.get(subject, ()) if since <= in_seconds(at)]
        if shares:
            return f"the battery of {subject} is at {100 * shares[-1]:.0f} %"
    return _side(log, happening, at)[2] if happening is not None else f"{_ENDS} of {subject}" if subject else _ENDS


def is_left_out(event: Event) -> bool:
    """Return whether an event shows nothing by itself: a lane that a fault closes, or a turn by no angle."""
    return isinstance(event, LaneEvent) or (isinstance(event, MotionBegan) and not event.duration)


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
