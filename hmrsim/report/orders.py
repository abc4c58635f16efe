"""The outcome of the orders: lead times, lateness, backlog."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from hmrsim.report import model
from hmrsim.report.html import in_seconds, rounded

if TYPE_CHECKING:
    from hmrsim.history.orders import Order
    from hmrsim.report.story import Story


def orders_of(story: Story) -> Iterator[model.Order]:
    """Yield the orders, in the order in which they came."""
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
        )


def demand_of(story: Story) -> model.Demand | None:
    """Return sums over all orders; None if there were none."""
    records = story.orders.all
    if not records:
        return None
    orders = [*orders_of(story)]
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
