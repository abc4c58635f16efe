"""The figures of a report: the outcomes of goals and orders, and the use of places."""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.protocol.goal import GoalStatus
from hmrsim.report import model
from hmrsim.report.delays import PARTS
from hmrsim.report.goals import count_waits, name_of, target_of
from hmrsim.report.html import in_seconds, rounded

if TYPE_CHECKING:
    from hmrsim.events.goals import SendGoalRejected
    from hmrsim.history.facilities import Use
    from hmrsim.history.items import Order
    from hmrsim.report.delays import Part
    from hmrsim.report.goals import GoalRecord, WaitRecord
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


def orders_of(story: Story, *, exact: bool) -> Iterator[model.Order]:
    """Yield the orders, in the order in which they came; the parts of their lead times are unknown without motions."""
    for record in story.orders.all:
        lead = None if record.ended is None or record.state != "delivered" else record.ended - record.placed
        over = record.ended if record.ended is not None else story.now
        yield model.Order(
            name=record.name,
            item=record.item,
            at=record.at,
            to=record.to,
            priority=record.priority,
            state=record.state,
            robot=record.robot,
            placed=in_seconds(record.placed),
            picked_up=None if record.picked_up is None else in_seconds(record.picked_up),
            ended=None if record.ended is None else in_seconds(record.ended),
            lead_time=None if lead is None else in_seconds(lead),
            lateness=in_seconds(max(0, over - record.due)) if record.late and record.due is not None else 0.0,
            delay=_delay(parts, 1) if exact and (parts := story.delays.of(record)) else None,
        )


def _delay(parts: Mapping[Part, int], orders: int) -> model.Delay:
    """Return the parts of the mean lead time of some orders."""
    return model.Delay(**{part: time / NANOSECONDS / orders for part, time in parts.items()})


def demand_of(story: Story, orders: Sequence[model.Order], *, exact: bool) -> model.Demand | None:
    """Return sums over all orders; None if there were none."""
    records = story.orders.all
    if not records:
        return None
    delays = [parts for record in records if (parts := story.delays.of(record))] if exact else []
    total = {part: sum(parts[part] for parts in delays) for part in PARTS}
    leads = sorted(order.lead_time for order in orders if order.lead_time is not None)
    late = [order.lateness for order in orders if order.lateness]
    mean, most = _backlog(records, story.began or 0, story.now)
    return model.Demand(
        placed=len(orders),
        delivered=len(leads),
        late=sum(record.late for record in records),
        lost=sum(record.state == "lost" for record in records),
        open=sum(record.ended is None for record in records),
        lead_time_mean=rounded(math.fsum(leads) / len(leads)) if leads else None,
        lead_time_p50=quantile(leads, 0.5),
        lead_time_p95=quantile(leads, 0.95),
        lead_time_max=leads[-1] if leads else None,
        delay=_delay(total, len(delays)) if delays else None,
        lateness_mean=rounded(math.fsum(late) / len(late)) if late else 0.0,
        lateness_max=max(late, default=0.0),
        backlog_mean=mean,
        backlog_max=most,
    )


def quantile(ordered: Sequence[float], share: float) -> float | None:
    """Return the least value up to which at least such a share of all values is; None of none."""
    return ordered[max(0, math.ceil(share * len(ordered)) - 1)] if ordered else None


def _backlog(records: Sequence[Order], began: int, now: int) -> tuple[float, int]:
    """Return how many orders were open, on average over time and at most."""
    changes = sorted([(record.placed, 1) for record in records] + [(each.ended, -1) for each in records if each.ended])
    total = most = there = 0
    last = began
    for at, change in changes:
        total += there * (at - last)
        there, last = there + change, at
        most = max(most, there)
    total += there * (now - last)
    return (rounded(total / (now - began)) if now > began else float(there)), most


_MAX_PATHS: Final = 5000


def lanes_of(story: Story) -> Iterator[model.Lane]:
    """Return the usage of lanes, by name; that off the lanes comes first."""
    drives, meters, times = Counter[Any](), defaultdict[Any, list[float]](list), Counter[Any]()
    for track in story.robot_log.tracks.values():
        for lane, use in track.lanes.items():
            drives[lane] += use.drives
            meters[lane].append(use.distance)
            times[lane] += use.time
    waits, waited = defaultdict[Any, list["WaitRecord"]](list), Counter[Any]()
    for wait in story.waiting.wait_records:
        if wait.kind == "way":
            waits[wait.lane].append(wait)
            waited[wait.lane] += wait.length
    closed = story.lanes.uses
    both = {*closed, *((b, a) for a, b in closed)}
    for lane in sorted({*drives, *waits, *both}, key=lambda each: each or ("", "")):
        shut = closed.get(lane) or (closed.get((lane[1], lane[0])) if lane else None)
        if lane in both and not drives[lane] and lane not in waits and lane not in closed:
            continue
        yield model.Lane(
            begin=lane[0] if lane else "",
            end=lane[1] if lane else "",
            drives=drives[lane],
            distance=rounded(math.fsum(meters[lane])),
            seconds=in_seconds(times[lane]),
            waits=count_waits(waits.get(lane, ())),
            waited=in_seconds(waited[lane]),
            closed=in_seconds(shut.time) if shut else 0.0,
        )


def paths_of(story: Story) -> Iterator[model.Path]:
    """Return the segments that were driven off the lanes; if there are too many, the most used ones."""
    paths = Counter[Any]()
    for track in story.robot_log.tracks.values():
        paths.update(track.paths)
    for (begin, end), drives in sorted(paths.most_common(_MAX_PATHS)):
        yield model.Path(begin=begin, end=end, drives=drives)


def fixtures_of(story: Story) -> Iterator[model.Fixture]:
    """Return the usage of doors, lifts and docks."""
    wait_records = story.waiting.wait_records
    whole = story.now - (story.began or 0)
    kinds: tuple[tuple[Any, dict[str, Use]], ...] = (
        ("door", story.doors.uses),
        ("lift", story.lifts.uses),
        ("dock", story.docks.uses),
    )
    for kind, uses in kinds:
        for name, use in sorted(uses.items()):
            waits = [each for each in wait_records if _is_for(each, kind, name)]
            yield model.Fixture(
                name=name,
                kind=kind,
                uses=use.uses,
                robots=len(use.robots),
                seconds=in_seconds(use.time),
                share=min(1.0, use.time / whole) if whole else 0.0,
                waits=count_waits(waits),
                waited=in_seconds(sum(wait.length for wait in waits)),
                longest_queue=use.queue if kind == "dock" else None,
            )


def _is_for(wait: WaitRecord, kind: str, name: str) -> bool:
    """Return whether a robot waited for a door, lift or dock; a reason begins with the door's or lift's name."""
    if kind == "dock":
        return wait.kind == "dock" and wait.why == name
    return wait.kind == "way" and wait.why.startswith(f"{name} is ")
