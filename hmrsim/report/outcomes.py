"""The goals in a report: their outcomes, their failures, and their ends over time."""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Iterator
from typing import TYPE_CHECKING, Final

from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.protocol.goal import GoalStatus
from hmrsim.report import model
from hmrsim.report.goals import name_of, target_of
from hmrsim.report.html import in_seconds, rounded

if TYPE_CHECKING:
    from hmrsim.events.goals import SendGoalRejected
    from hmrsim.report.goals import GoalRecord
    from hmrsim.report.story import Story

_BUCKETS: Final = 40
"""Approximate number of intervals in which goals are counted."""


def goal_of(goal: GoalRecord, *, exact: bool) -> model.Goal:
    """Return the entry of a goal; its distance is unknown without motions."""
    target, at = target_of(goal.asked)
    return model.Goal(
        robot=goal.robot,
        action=goal.action,
        goal_id=goal.goal_id,
        accepted=in_seconds(goal.accepted),
        ended=None if goal.ended is None else in_seconds(goal.ended),
        duration=None if goal.ended is None else in_seconds(goal.ended - goal.accepted),
        status=goal.status.name,
        target=target,
        target_x=at[0] if at else None,
        target_y=at[1] if at else None,
        distance=rounded(goal.distance) if exact else None,
        waited=in_seconds(goal.waited),
        waits=goal.waits,
        reroutes=goal.reroutes,
        error_code=goal.error_code if goal.status is GoalStatus.ABORTED else None,
        error_msg=goal.error_msg,
    )


def errors_of(story: Story) -> Iterator[model.Error]:
    """Return the errors, in order of time."""
    found = [_aborted(goal) for goal in story.goal_log.goals if goal.status is GoalStatus.ABORTED]
    found += [_rejected(*each) for each in story.goal_log.rejected]
    yield from sorted(found, key=lambda error: (error.at, error.robot, error.goal_id))


def _aborted(goal: GoalRecord) -> model.Error:
    wait = goal.waiting
    return model.Error(
        at=in_seconds(goal.ended or 0),
        robot=goal.robot,
        action=goal.action,
        goal_id=goal.goal_id,
        status="ABORTED",
        error_code=goal.error_code,
        error_name=name_of(goal.action, goal.error_code),
        error_msg=goal.error_msg,
        target=target_of(goal.asked)[0],
        waited_for=wait.what if wait else "",
        waiting_since=in_seconds(wait.began) if wait else None,
        faults=goal.faults,
        deadlock=goal.deadlock,
    )


def _rejected(at: int, event: SendGoalRejected, faults: tuple[str, ...]) -> model.Error:
    return model.Error(
        at=in_seconds(at),
        robot=event.robot,
        action=event.action,
        goal_id=event.goal_id,
        error_msg=event.error_msg,
        status="REJECTED",
        error_code=None,
        error_name=event.reason,
        target="",
        waited_for="",
        waiting_since=None,
        faults=faults,
        deadlock=False,
    )


def throughput_of(story: Story) -> Iterator[model.Bucket]:
    """Return the numbers of goals that ended, by interval."""
    began, ended = story.began or 0, story.now
    if ended <= began:
        return
    width = _nice((ended - began) / NANOSECONDS / _BUCKETS) * NANOSECONDS
    counts: dict[int, Counter[GoalStatus]] = defaultdict(Counter)
    number = math.ceil((ended - began) / width)
    for goal in story.goal_log.goals:
        if goal.ended is not None:
            counts[min(number - 1, int((goal.ended - began) // width))][goal.status] += 1
    for i in range(number):
        yield model.Bucket(
            began=(began + i * width) / NANOSECONDS,
            ended=(began + (i + 1) * width) / NANOSECONDS,
            succeeded=counts[i][GoalStatus.SUCCEEDED],
            canceled=counts[i][GoalStatus.CANCELED],
            aborted=counts[i][GoalStatus.ABORTED],
        )


def _nice(seconds: float) -> float:
    """Return a round length of time that is not less than some seconds."""
    for step in (0.1, 0.2, 0.5, 1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600):
        if step >= seconds:
            return step
    return math.ceil(seconds / 3600) * 3600.0
