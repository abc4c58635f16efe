"""Goals that a controller omits: kinds of goals that only the passing run has, and long times without any goal."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Final, NamedTuple

from hmrsim.events.goals import GoalAccepted, GoalStatusChanged, SendGoalRejected
from hmrsim.protocol.goal import GoalStatus
from hmrsim.report.html import in_seconds

if TYPE_CHECKING:
    from hmrsim.run_page.run_log import RunLog

ALSO: Final = " (also in the passing run)"
"""The end of a text that is true of both runs."""
LOW: Final = 0.5
"""The share of a battery's charge below which a goal is shown with it."""


def robots_in(texts: Sequence[str], log: RunLog) -> list[str]:
    """Return the robots that texts name, and those with goals for an item or an order that they name."""
    words = " ".join(texts)
    found = {robot: None for robot in log.poses if _named(robot, words)}
    items = [item for item in log.changes("item") if _named(item, words)]
    for each in log.happenings:
        if items and isinstance(each.event, GoalAccepted):
            text = log.describe(each.event)
            if any(_named(item, text) for item in items):
                found[each.event.robot] = None
    return [*found]


def _named(name: str, text: str) -> bool:
    return re.search(rf"(?<![\w-]){re.escape(name)}(?![\w-])", text) is not None


_MOST_NAMED: Final = 3
"""The maximum number of robots whose goals of an action are named."""


class Omission(NamedTuple):
    """Goals that only another run has.

    Attributes:
        at: When it has the first one, in seconds since it began.
        text: The goals in words.
    """

    at: float
    text: str


def never_sent(log: RunLog, other: RunLog, until: float) -> Iterator[Omission]:
    """Yield, for each action that robots get until some time in another run only, the first goal of each robot."""
    sent = {each.event.action for each in log.happenings if isinstance(each.event, GoalAccepted | SendGoalRejected)}
    firsts: dict[str, dict[str, Omission]] = defaultdict(dict)
    for each in other.happenings:
        event, at = each.event, in_seconds(each.at)
        if isinstance(event, GoalAccepted) and event.action not in sent and at <= until:
            goals = firsts[event.action]
            if event.robot not in goals:
                text = f"{goal_text(other, event)}{charge_at(other, event.robot, each.at)}"
                goals[event.robot] = Omission(at, text)
    for action, goals in firsts.items():
        first, *more = [*goals.values()][:_MOST_NAMED]
        also = "".join(f", {text} at {at:.3f} s" for at, text in more)
        yield Omission(first.at, f"{first.text}{also}; here, no robot gets a goal of {action}")


def longest_pause(robot: str, log: RunLog, until: float) -> tuple[float, float]:
    """Return the longest time before a goal of a robot, but not after its last one, without any other one."""
    executing: set[str] = set()
    since, longest = 0.0, (0.0, 0.0)
    for each in log.happenings:
        event, at = each.event, in_seconds(each.at)
        if not isinstance(event, GoalAccepted | GoalStatusChanged | SendGoalRejected) or event.robot != robot:
            continue
        if isinstance(event, GoalStatusChanged):
            if GoalStatus(event.status).terminal:
                executing.discard(event.goal_id)
                since = at
            continue
        if not executing and at - since > longest[1] - longest[0] and since < until:
            longest = since, at
        if isinstance(event, GoalAccepted):
            executing.add(event.goal_id)
        since = at
    return longest


def goal_text(log: RunLog, event: GoalAccepted) -> str:
    """Return a goal in words, such as ``eve navigate_to_pose: store``."""
    return log.describe(event).replace(" accepted", "", 1)


def charge_at(log: RunLog, robot: str, at: int) -> str:
    """Return the charge of a robot's battery at a time in nanoseconds, in brackets; empty if it is not low."""
    shares = [share for since, share in log.report().batteries.get(robot, ()) if since <= in_seconds(at)]
    return f" (battery at {100 * shares[-1]:.0f} %)" if shares and shares[-1] < LOW else ""
