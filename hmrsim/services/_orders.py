"""Messages of orders."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.engine.sim_time import nanoseconds
from hmrsim.interfaces.builtin_interfaces import Time
from hmrsim.interfaces.hmrsim_msgs import Order as OrderMessage

if TYPE_CHECKING:
    from hmrsim.simulation.orders import Order


def message_of(order: Order) -> OrderMessage:
    """Return an order as a message; times that it does not have are zero."""
    return OrderMessage(
        name=order.name,
        demand=order.demand,
        item=order.item,
        at=order.at,
        to=order.to,
        priority=order.priority,
        state=order.state.value,
        robot=order.robot,
        late=order.late,
        placed=_time(order.placed),
        due=_time(order.due),
        picked_up=_time(order.picked_up),
        ended=_time(order.ended),
    )


def _time(seconds: float | None) -> Time:
    return Time.from_nanoseconds(0 if seconds is None else nanoseconds(seconds))
